#include "server/jobs/file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace rivage::server {

using core::ErrorCode;
using core::fail;

core::Error diskError(const std::string& doing, int code) {
    if (code == ENOSPC || code == EDQUOT)
        return {.code = ErrorCode::storageFull,
                .message = "the server has no room on its disk to " + doing,
                .setting = "--state-dir"};
    return {
        .code = ErrorCode::internal,
        .message = "the server could not " + doing + ": " + std::generic_category().message(code)};
}

core::Result<void> makeFolder(const std::string& path) {
    for (std::size_t slash = path.find('/', 1); slash != std::string::npos;
         slash = path.find('/', slash + 1))
        ::mkdir(path.substr(0, slash).c_str(), 0700);  // what fails here fails below
    if (::mkdir(path.c_str(), 0700) == 0) return {};
    const int code = errno;
    struct stat status {};
    const bool usable = ::stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
                        ::access(path.c_str(), W_OK | X_OK) == 0;
    if (usable) return {};
    return fail(diskError("use the folder of --state-dir", code == EEXIST ? ENOTDIR : code));
}

core::Result<void> writeDurably(const Fd& file, std::span<const std::byte> bytes) {
    std::size_t written = 0;
    while (written < bytes.size()) {
        const ssize_t n = ::write(file.get(), bytes.data() + written, bytes.size() - written);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return fail(diskError("keep these bytes", errno));
        written += static_cast<std::size_t>(n);
    }
    if (::fsync(file.get()) != 0) return fail(diskError("keep these bytes", errno));
    return {};
}

core::Result<void> syncFolder(const std::string& path) {
    const Fd folder(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!folder || ::fsync(folder.get()) != 0) return fail(diskError("keep these bytes", errno));
    return {};
}

core::Result<Fd> lockFolder(const std::string& folder) {
    if (auto made = makeFolder(folder); !made) return fail(made.error());
    Fd file(::open((folder + "/lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
    if (!file) return fail(diskError("use the folder of --state-dir", errno));
    if (::flock(file.get(), LOCK_EX | LOCK_NB) == 0) return file;
    if (errno != EWOULDBLOCK) return fail(diskError("lock the folder of --state-dir", errno));
    return fail(ErrorCode::busy, "another server uses --state-dir " + folder +
                                     ": stop it, or give this one a folder of its own");
}

}  // namespace rivage::server
