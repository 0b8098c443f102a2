#include "server/jobs/disk_blob_store.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>

#include "server/jobs/file.h"

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

/// Below, a copy in memory costs less than a mapping's pages.
constexpr std::size_t kMapFrom = 64 << 10;

/// The bytes of a file: mapped if they are many, else read.
class FileBytes {
public:
    /// @errors notFound if there is no such file; internal
    static core::Result<FileBytes> read(const std::string& path);
    FileBytes() = default;
    FileBytes(FileBytes&& other) noexcept
        : small_(std::move(other.small_)), map_(std::exchange(other.map_, {})) {}
    FileBytes& operator=(FileBytes&&) = delete;
    ~FileBytes() {
        if (!map_.empty()) ::munmap(map_.data(), map_.size());
    }
    [[nodiscard]] std::span<const std::byte> bytes() const {
        return map_.empty() ? std::span<const std::byte>(small_) : map_;
    }
    /// The pages leave this process's memory until they are read again.
    void unload() const {
        if (!map_.empty()) ::madvise(map_.data(), map_.size(), MADV_DONTNEED);
    }

private:
    std::vector<std::byte> small_;
    std::span<std::byte> map_;
};

core::Result<FileBytes> FileBytes::read(const std::string& path) {
    const Fd file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
    if (!file && errno == ENOENT) return fail(ErrorCode::notFound, "these bytes are not kept");
    struct stat status {};
    if (!file || ::fstat(file.get(), &status) != 0)
        return fail(diskError("read kept bytes", errno));
    const auto size = static_cast<std::size_t>(status.st_size);
    FileBytes result;
    if (size >= kMapFrom) {
        void* const map = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file.get(), 0);
        if (map == MAP_FAILED) return fail(diskError("read kept bytes", errno));
        result.map_ = {static_cast<std::byte*>(map), size};
        return result;
    }
    result.small_.resize(size);
    for (std::size_t done = 0; done < size;) {
        const ssize_t n = ::read(file.get(), result.small_.data() + done, size - done);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return fail(diskError("read kept bytes", n < 0 ? errno : EIO));
        done += static_cast<std::size_t>(n);
    }
    return result;
}

class DiskBlob final : public Blob {
public:
    DiskBlob(Digest digest, FileBytes file) : Blob(std::move(digest)), file_(std::move(file)) {}
    [[nodiscard]] std::span<const std::byte> bytes() const override { return file_.bytes(); }
    [[nodiscard]] bool durable() const override { return true; }

private:
    const FileBytes file_;
};

bool looksLikeSha256(const std::string& hex) {
    return hex.size() == 64 && std::all_of(hex.begin(), hex.end(), [](char c) {
               return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
           });
}

/// What is in a folder; as much of it as can be read.
std::vector<std::filesystem::path> filesIn(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    std::error_code error;
    std::filesystem::directory_iterator entry(folder, error);
    for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error))
        files.push_back(entry->path());
    return files;
}

/// The files are written and read without a lock. What `collect` must not remove has an entry in
/// `entries_`: blobs that are held, and those that somebody is about to hold.
class DiskBlobStore final : public BlobStore {
public:
    explicit DiskBlobStore(const std::string& folder)
        : blobs_(folder + "/blobs"), temporary_(folder + "/tmp") {}

    core::Result<void> prepare();
    core::Result<BlobPtr> put(std::vector<std::byte> bytes) override;
    core::Result<BlobPtr> open(const Digest& digest) override;
    void collect(const std::function<bool(const std::string& hex)>& needed) override;

private:
    struct Entry {
        std::weak_ptr<const Blob> blob;
        int users = 0;  ///< calls of `put` and `open` that are under way
    };

    [[nodiscard]] std::string folderOf(const std::string& hex) const {
        return blobs_ + "/" + hex.substr(0, 2);
    }
    BlobPtr enter(const std::string& hex);
    BlobPtr leave(const std::string& hex, BlobPtr made);
    core::Result<FileBytes> keep(const std::string& hex, std::span<const std::byte> bytes);
    core::Result<void> write(const std::string& hex, std::span<const std::byte> bytes);
    void removeUnlessUsed(const std::filesystem::path& file, const std::string& hex);

    const std::string blobs_;
    const std::string temporary_;
    std::atomic<std::uint64_t> counter_{0};
    std::mutex collecting_;
    std::mutex mutex_;  ///< of `entries_`, and of removing files
    std::map<std::string, Entry> entries_;
};

core::Result<void> DiskBlobStore::prepare() {
    for (const std::string& folder : {blobs_, temporary_})
        if (auto made = makeFolder(folder); !made) return made;
    std::error_code error;
    for (const auto& leftover : filesIn(temporary_)) std::filesystem::remove_all(leftover, error);
    if (error) return fail(diskError("clear its temporary files", error.value()));
    return {};
}

/// Announces the use of a blob. @return it, if somebody holds it already; then there is no `leave`
BlobPtr DiskBlobStore::enter(const std::string& hex) {
    const std::lock_guard lock(mutex_);
    Entry& entry = entries_[hex];
    BlobPtr held = entry.blob.lock();
    if (!held) ++entry.users;
    return held;
}

/// Ends the use. @param made  null if there is no blob after all
/// @return the one object of this digest: of two threads that made it, the later gets the earlier's
BlobPtr DiskBlobStore::leave(const std::string& hex, BlobPtr made) {
    const std::lock_guard lock(mutex_);
    Entry& entry = entries_[hex];
    --entry.users;
    if (BlobPtr other = entry.blob.lock()) return other;
    entry.blob = made;
    return made;
}

core::Result<BlobPtr> DiskBlobStore::put(std::vector<std::byte> bytes) {
    Digest digest = sha256(bytes);
    if (BlobPtr held = enter(digest.hex)) return held;
    auto kept = keep(digest.hex, bytes);
    if (!kept) {
        leave(digest.hex, nullptr);
        return fail(kept.error());
    }
    const std::string hex = digest.hex;
    return leave(hex, std::make_shared<const DiskBlob>(std::move(digest), *std::move(kept)));
}

/// A file that is there and has these bytes is used again.
core::Result<FileBytes> DiskBlobStore::keep(const std::string& hex,
                                            std::span<const std::byte> bytes) {
    const std::string path = folderOf(hex) + "/" + hex;
    auto file = FileBytes::read(path);
    const bool there = file && std::ranges::equal(file->bytes(), bytes);
    if (!there)
        if (auto written = write(hex, bytes); !written) return fail(written.error());
    // Also for a file that was there: who renamed it may have crashed before this.
    if (auto synced = syncFolder(folderOf(hex)); !synced) return fail(synced.error());
    if (!there) return FileBytes::read(path);
    file->unload();
    return file;
}

core::Result<void> DiskBlobStore::write(const std::string& hex, std::span<const std::byte> bytes) {
    const std::string folder = folderOf(hex);
    struct stat status {};
    if (::stat(folder.c_str(), &status) != 0) {
        if (auto made = makeFolder(folder); !made) return made;
        if (auto synced = syncFolder(blobs_); !synced) return synced;
    }
    const std::string path = temporary_ + "/" + hex + "." + std::to_string(++counter_);
    const Fd file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
    if (!file) return fail(diskError("keep these bytes", errno));
    auto written = writeDurably(file, bytes);
    if (written && ::rename(path.c_str(), (folder + "/" + hex).c_str()) != 0)
        written = fail(diskError("keep these bytes", errno));
    if (!written) ::unlink(path.c_str());
    return written;
}

core::Result<BlobPtr> DiskBlobStore::open(const Digest& digest) {
    if (!looksLikeSha256(digest.hex)) return fail(ErrorCode::notFound, "these bytes are not kept");
    if (BlobPtr held = enter(digest.hex)) return held;
    auto file = FileBytes::read(folderOf(digest.hex) + "/" + digest.hex);
    Digest actual = file ? sha256(file->bytes()) : Digest{};
    if (file && actual.hex != digest.hex)
        file = fail(ErrorCode::internal, "the kept bytes are damaged");
    if (!file) {
        leave(digest.hex, nullptr);
        return fail(file.error());
    }
    file->unload();
    return leave(digest.hex, std::make_shared<const DiskBlob>(std::move(actual), *std::move(file)));
}

/// An entry that is unused now goes first. One that appears from here on protects its file: only
/// who has put or opened the blob after `needed` was asked can have come to need it.
void DiskBlobStore::collect(const std::function<bool(const std::string& hex)>& needed) {
    const std::lock_guard alone(collecting_);
    {
        const std::lock_guard lock(mutex_);
        std::erase_if(entries_, [](const auto& entry) {
            return entry.second.users == 0 && entry.second.blob.expired();
        });
    }
    for (const auto& folder : filesIn(blobs_))
        for (const auto& file : filesIn(folder)) {
            const std::string hex = file.filename().string();
            if (looksLikeSha256(hex) && !needed(hex)) removeUnlessUsed(file, hex);
        }
}

void DiskBlobStore::removeUnlessUsed(const std::filesystem::path& file, const std::string& hex) {
    const std::lock_guard lock(mutex_);
    if (!entries_.contains(hex)) ::unlink(file.c_str());
}

}  // namespace

core::Result<std::unique_ptr<BlobStore>> openDiskBlobStore(const std::string& folder) {
    auto store = std::make_unique<DiskBlobStore>(folder);
    if (auto prepared = store->prepare(); !prepared) return fail(prepared.error());
    return store;
}

}  // namespace rivage::server
