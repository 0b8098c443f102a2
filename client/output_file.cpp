#include "client/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

namespace rivage::client {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Failure> cannotWrite(const std::string& path, int error) {
    return fail(ExitCode::notWritten, "The output cannot be written",
                path + ": " + std::strerror(error));
}

/// The mode that a new file would have.
mode_t newFileMode() {
    const mode_t mask = umask(0);
    umask(mask);
    return 0666 & ~mask;
}

}  // namespace

Outcome<OutputFile> OutputFile::open(const std::string& path) {
    OutputFile file;
    std::error_code code;
    file.path_ = fs::is_symlink(path, code) ? fs::canonical(path, code).string() : path;
    if (file.path_.empty()) return cannotWrite(path, code.value());
    struct stat status {};
    const bool exists = stat(file.path_.c_str(), &status) == 0;
    if (exists && S_ISDIR(status.st_mode)) return cannotWrite(path, EISDIR);
    if (exists && !S_ISREG(status.st_mode)) {
        file.file_ = ::open(file.path_.c_str(), O_WRONLY | O_CLOEXEC);
        if (file.file_ < 0) return cannotWrite(path, errno);
        return file;
    }

    const fs::path target(file.path_);
    file.temporary_ =
        (target.parent_path() / ("." + target.filename().string() + ".XXXXXX")).string();
    file.file_ = mkostemp(file.temporary_.data(), O_CLOEXEC);
    if (file.file_ < 0) {
        const int error = errno;
        file.temporary_.clear();
        return cannotWrite(path, error);
    }
    fchmod(file.file_, exists ? status.st_mode & 07777 : newFileMode());
    return file;
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : file_(std::exchange(other.file_, -1)),
      error_(other.error_),
      size_(other.size_),
      path_(std::move(other.path_)),
      temporary_(std::exchange(other.temporary_, {})) {}

OutputFile::~OutputFile() {
    if (file_ >= 0) close(file_);
    if (!temporary_.empty()) unlink(temporary_.c_str());
}

bool OutputFile::write(std::string_view bytes) {
    while (!bytes.empty() && error_ == 0) {
        const ssize_t written = ::write(file_, bytes.data(), bytes.size());
        if (written < 0) {
            if (errno != EINTR) error_ = errno;
            continue;
        }
        bytes.remove_prefix(static_cast<std::size_t>(written));
        size_ += static_cast<std::uint64_t>(written);
    }
    return error_ == 0;
}

bool OutputFile::restart() {
    if (size_ == 0) return true;
    if (temporary_.empty()) return false;
    size_ = 0;
    return ftruncate(file_, 0) == 0 && lseek(file_, 0, SEEK_SET) == 0;
}

Outcome<void> OutputFile::commit() {
    if (auto finished = finish(); !finished) return finished;
    if (temporary_.empty()) return {};
    if (rename(temporary_.c_str(), path_.c_str()) != 0) return cannotWrite(path_, errno);
    temporary_.clear();
    // The rename lasts once the folder is on the disk; a folder that cannot be opened is no error.
    const std::string folder = fs::path(path_).parent_path().string();
    const int opened = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_CLOEXEC);
    if (opened >= 0) {
        fsync(opened);
        close(opened);
    }
    return {};
}

Outcome<void> OutputFile::finish() {
    if (error_ == 0 && !temporary_.empty() && fsync(file_) != 0) error_ = errno;
    const bool closed = close(std::exchange(file_, -1)) == 0;
    if (error_ == 0 && !closed) error_ = errno;
    return writable();
}

Outcome<void> OutputFile::writable() const {
    if (error_ != 0) return cannotWrite(path_, error_);
    return {};
}

}  // namespace rivage::client
