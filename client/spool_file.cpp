#include "client/spool_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>

namespace rivage::client {
namespace {

tl::unexpected<Failure> notKept(int error) {
    return fail(ExitCode::notWritten, "The result could not be kept until it is whole",
                std::string(std::strerror(error)) + "; TMPDIR names the folder for such files");
}

}  // namespace

Outcome<SpoolFile> SpoolFile::open() {
    std::error_code error;
    const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
    std::string name = (folder / "rivage.XXXXXX").string();
    SpoolFile spool;
    if (!error) spool.file_ = mkostemp(name.data(), O_CLOEXEC);
    if (spool.file_ >= 0)
        unlink(name.c_str());
    else  // as in a container whose files are read-only
        spool.file_ = memfd_create("rivage", MFD_CLOEXEC);
    if (spool.file_ < 0) return notKept(errno);
    return spool;
}

SpoolFile::~SpoolFile() {
    if (file_ >= 0) close(file_);
}

bool SpoolFile::write(std::string_view bytes) {
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

bool SpoolFile::restart() {
    size_ = 0;
    return ftruncate(file_, 0) == 0 && lseek(file_, 0, SEEK_SET) == 0;
}

Outcome<void> SpoolFile::writable() const {
    if (error_ != 0) return notKept(error_);
    return {};
}

bool SpoolFile::copyTo(const std::function<bool(std::string_view)>& take) const {
    std::string chunk(std::size_t{1} << 16, '\0');
    for (std::uint64_t at = 0; at < size_;) {
        const std::size_t wanted = std::min<std::uint64_t>(chunk.size(), size_ - at);
        const ssize_t read = pread(file_, chunk.data(), wanted, static_cast<off_t>(at));
        if (read < 0 && errno == EINTR) continue;
        if (read <= 0) return false;
        if (!take({chunk.data(), static_cast<std::size_t>(read)})) return false;
        at += static_cast<std::uint64_t>(read);
    }
    return true;
}

}  // namespace rivage::client
