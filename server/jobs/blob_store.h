#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/jobs/digest.h"

namespace rivage::server {

/// Bytes that never change, known by their sha-256. While one is held, its store keeps the bytes.
class Blob {
public:
    virtual ~Blob() = default;
    /// Valid as long as the blob. Safe to call from several threads.
    [[nodiscard]] virtual std::span<const std::byte> bytes() const = 0;
    [[nodiscard]] const Digest& digest() const { return digest_; }
    /// Whether the bytes outlive the process.
    [[nodiscard]] virtual bool durable() const { return false; }

protected:
    explicit Blob(Digest digest) : digest_(std::move(digest)) {}

private:
    const Digest digest_;
};

using BlobPtr = std::shared_ptr<const Blob>;

/// Where the bytes of grids and results are. Content-addressed: the same bytes are kept once.
class BlobStore {
public:
    virtual ~BlobStore() = default;
    /// Keeps bytes; on return they are as durable as the store is.
    /// @errors storageFull; internal
    virtual core::Result<BlobPtr> put(std::vector<std::byte> bytes) = 0;
    /// A blob that an earlier process has put. @errors notFound; internal if its bytes are damaged
    virtual core::Result<BlobPtr> open(const Digest& digest) = 0;
    /// Gives up what no one needs any more: every stored blob that is not held and for whose
    /// digest (hex) `needed` is false.
    virtual void collect(const std::function<bool(const std::string& hex)>& needed) = 0;
};

/// Keeps nothing by itself: a blob lives as long as it is held.
class MemoryBlobStore final : public BlobStore {
public:
    MemoryBlobStore();
    core::Result<BlobPtr> put(std::vector<std::byte> bytes) override;
    core::Result<BlobPtr> open(const Digest& digest) override;
    void collect(const std::function<bool(const std::string& hex)>& needed) override;

private:
    struct Held;
    std::shared_ptr<Held> held_;  ///< also of the blobs, which may outlive the store
};

}  // namespace rivage::server
