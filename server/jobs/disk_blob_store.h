#pragma once

#include <memory>
#include <string>

#include "server/jobs/blob_store.h"

namespace rivage::server {

/// Blobs as files `blobs/ab/<sha-256>` of a folder. A file has this name only once all its bytes
/// are on the disk, so a crash leaves whole blobs and, in `tmp/`, what is removed here.
/// Blobs of 64 KiB and more are mapped: they take address space, and memory only while it is free.
///
/// @param folder  of one process at a time (`lockFolder`); made if it is not there
/// @errors        storageFull; internal
core::Result<std::unique_ptr<BlobStore>> openDiskBlobStore(const std::string& folder);

}  // namespace rivage::server
