#include "server/jobs/blob_store.h"

#include <map>
#include <mutex>
#include <utility>

namespace rivage::server {

/// The blobs that somebody holds, by their sha-256 (hex). Each takes itself out when it goes.
struct MemoryBlobStore::Held {
    std::mutex mutex;
    std::map<std::string, std::weak_ptr<const Blob>> blobs;
};

namespace {

class MemoryBlob final : public Blob {
public:
    MemoryBlob(Digest digest, std::vector<std::byte> bytes)
        : Blob(std::move(digest)), bytes_(std::move(bytes)) {}
    [[nodiscard]] std::span<const std::byte> bytes() const override { return bytes_; }

private:
    const std::vector<std::byte> bytes_;
};

}  // namespace

MemoryBlobStore::MemoryBlobStore() : held_(std::make_shared<Held>()) {}

core::Result<BlobPtr> MemoryBlobStore::put(std::vector<std::byte> bytes) {
    const auto remove = [held = held_](const Blob* blob) {
        {
            const std::lock_guard lock(held->mutex);
            const auto found = held->blobs.find(blob->digest().hex);
            // Another with the same bytes may stand there.
            if (found != held->blobs.end() && found->second.expired()) held->blobs.erase(found);
        }
        delete blob;
    };
    Digest digest = sha256(bytes);
    const BlobPtr made(new MemoryBlob(std::move(digest), std::move(bytes)), remove);
    const std::lock_guard lock(held_->mutex);
    std::weak_ptr<const Blob>& entry = held_->blobs[made->digest().hex];
    if (BlobPtr known = entry.lock()) return known;
    entry = made;
    return made;
}

core::Result<BlobPtr> MemoryBlobStore::open(const Digest&) {
    return core::fail(core::ErrorCode::notFound, "these bytes are not kept");
}

void MemoryBlobStore::collect(const std::function<bool(const std::string&)>&) {}

}  // namespace rivage::server
