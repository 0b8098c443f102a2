#pragma once

#include <memory>
#include <string>

#include "server/jobs/job_store.h"

namespace rivage::server {

/// Job records in the SQLite database `jobs.sqlite` of a folder. Each record is on the disk when
/// `save` returns; a crash at any moment leaves the records that were saved.
///
/// @param folder  of one process at a time (`lockFolder`); made if it is not there
/// @errors        storageFull; internal, also if the database is damaged or of a newer server
core::Result<std::unique_ptr<JobStore>> openSqliteJobStore(const std::string& folder);

}  // namespace rivage::server
