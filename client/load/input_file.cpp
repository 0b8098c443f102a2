#include "client/load/input_file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace rivage::client::load {
namespace {

using Clock = std::chrono::steady_clock;

/// How often a wait looks whether it is to go on.
constexpr std::chrono::milliseconds kLook{50};
constexpr std::size_t kPiece = 1 << 20;

/// A descriptor that is closed at last.
struct Opened {
    explicit Opened(int number) : fd(number) {}
    ~Opened() {
        if (fd >= 0) close(fd);
    }
    Opened(const Opened&) = delete;
    Opened& operator=(const Opened&) = delete;
    const int fd;
};

std::string sizeText(std::size_t bytes) {
    const std::size_t mega = bytes >> 20;
    return mega > 0 ? std::to_string(mega) + " MiB" : std::to_string(bytes) + " bytes";
}

/// @return what is wrong with this kind of file, or empty
std::string kindFault(const struct stat& status, const InputBounds& bounds) {
    if (S_ISDIR(status.st_mode)) return "it is a folder";
    if (S_ISCHR(status.st_mode) || S_ISBLK(status.st_mode)) return "it is a device, not a file";
    if (S_ISREG(status.st_mode) && static_cast<std::size_t>(status.st_size) > bounds.bytes)
        return "it has more than " + sizeText(bounds.bytes);
    return {};
}

/// Waits until there is something to read, or the end. @return what is wrong, or empty
std::string await(int fd, Clock::time_point until, const InputBounds& bounds,
                  const Interrupt& interrupt) {
    pollfd wait{fd, POLLIN, 0};
    while (::poll(&wait, 1, static_cast<int>(kLook.count())) <= 0) {
        if (interrupt.requested()) return "cancelled";
        if (Clock::now() > until)
            return "it did not end within " +
                   std::to_string(std::chrono::ceil<std::chrono::seconds>(bounds.time).count()) +
                   " s";
    }
    return {};
}

}  // namespace

Outcome<std::string> readInput(const std::string& what, const std::string& path,
                               const InputBounds& bounds, const Interrupt& interrupt) {
    const auto bad = [&](const std::string& why) {
        return fail(interrupt.requested() ? ExitCode::cancelled : ExitCode::usage,
                    "The " + what + " " + proto::inQuotes(path) + " cannot be read", why);
    };
    // A pipe without a writer would else keep open() itself.
    const Opened file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    struct stat status {};
    if (file.fd < 0 || fstat(file.fd, &status) != 0) return bad(std::strerror(errno));
    if (const std::string wrong = kindFault(status, bounds); !wrong.empty()) return bad(wrong);
    const auto until = Clock::now() + bounds.time;
    std::string bytes;
    for (;;) {
        const std::string wrong = await(file.fd, until, bounds, interrupt);
        if (!wrong.empty()) return bad(wrong);
        const std::size_t before = bytes.size();
        bytes.resize(before + std::min(kPiece, bounds.bytes + 1 - before));
        const ssize_t got = ::read(file.fd, bytes.data() + before, bytes.size() - before);
        bytes.resize(before + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
        if (got == 0) return bytes;
        if (got < 0 && errno != EAGAIN && errno != EINTR) return bad(std::strerror(errno));
        if (bytes.size() > bounds.bytes) return bad("it has more than " + sizeText(bounds.bytes));
    }
}

}  // namespace rivage::client::load
