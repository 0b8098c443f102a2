#include "client/output_file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <thread>
#include <utility>

#include "client/printable.h"

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

Outcome<OutputFile> OutputFile::open(const std::string& path, const Interrupt* interrupt) {
    OutputFile file;
    file.interrupt_ = interrupt;
    std::error_code code;
    file.path_ = fs::is_symlink(path, code) ? fs::canonical(path, code).string() : path;
    if (file.path_.empty()) return cannotWrite(path, code.value());
    struct stat status {};
    const bool exists = stat(file.path_.c_str(), &status) == 0;
    if (exists && S_ISDIR(status.st_mode)) return cannotWrite(path, EISDIR);
    if (exists && S_ISFIFO(status.st_mode)) {
        if (auto opened = file.openPipe(); !opened) return tl::unexpected(opened.error());
        return file;
    }
    if (exists && !S_ISREG(status.st_mode)) {
        file.file_ = ::open(file.path_.c_str(), O_WRONLY | O_CLOEXEC);
        if (file.file_ < 0) return cannotWrite(path, errno);
        return file;
    }

    const mode_t mode = exists ? status.st_mode & 07777 : newFileMode();
    if (auto opened = file.openBeside(mode); !opened) return tl::unexpected(opened.error());
    return file;
}

/// A pipe can be opened when somebody reads it. Neither that nor writing to it may block here,
/// where a stop could not end it.
Outcome<void> OutputFile::openPipe() {
    constexpr std::chrono::milliseconds kStep{20};
    for (;;) {
        file_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
        if (file_ >= 0) return {};
        if (errno != ENXIO) return cannotWrite(path_, errno);
        if (interrupt_ == nullptr)
            std::this_thread::sleep_for(kStep);
        else if (!interrupt_->sleep(kStep))
            return fail(ExitCode::cancelled, "Cancelled");
    }
}

Outcome<void> OutputFile::openBeside(unsigned mode) {
    constexpr std::size_t kShown = 200;  // bytes of the name: one may have 255, with what is added
    const fs::path target(path_);
    temporary_ =
        (target.parent_path() / ("." + cutTo(target.filename().string(), kShown) + ".XXXXXX"))
            .string();
    file_ = mkostemp(temporary_.data(), O_CLOEXEC);
    if (file_ < 0) {
        const int error = errno;
        temporary_.clear();
        return cannotWrite(path_, error);
    }
    fchmod(file_, mode);
    return {};
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : file_(std::exchange(other.file_, -1)),
      error_(other.error_),
      size_(other.size_),
      interrupt_(other.interrupt_),
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
            const bool full = errno == EAGAIN;
            if (full && !mayGoOn(POLLOUT)) error_ = ECANCELED;
            if (!full && errno != EINTR) error_ = errno;
            continue;
        }
        bytes.remove_prefix(static_cast<std::size_t>(written));
        size_ += static_cast<std::uint64_t>(written);
    }
    return error_ == 0;
}

bool OutputFile::mayGoOn(short events) const {
    if (interrupt_ != nullptr) return interrupt_->await(file_, events);
    pollfd wanted{file_, events, 0};
    return poll(&wanted, 1, -1) >= 0;
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
