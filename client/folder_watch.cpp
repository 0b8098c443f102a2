#include "client/folder_watch.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

namespace rivage::client {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kEvents = IN_CLOSE_WRITE | IN_MOVED_TO | IN_MOVED_FROM | IN_CREATE |
                                  IN_DELETE | IN_DELETE_SELF | IN_MOVE_SELF;
constexpr milliseconds kQuiet{100};     ///< no change for so long: it is over
constexpr milliseconds kLongest{2000};  ///< and if it never is, so long

tl::unexpected<Failure> cannotWatch(const std::string& what) {
    return fail(ExitCode::failed, "The folders cannot be watched",
                what + ": " + std::strerror(errno));
}

}  // namespace

Outcome<FolderWatch> FolderWatch::open() {
    FolderWatch watch;
    watch.file_ = inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
    if (watch.file_ < 0) return cannotWatch("inotify");
    return watch;
}

FolderWatch::FolderWatch(FolderWatch&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

FolderWatch::~FolderWatch() {
    if (file_ >= 0) close(file_);
}

Outcome<void> FolderWatch::add(const std::string& folder, bool deep) {
    if (inotify_add_watch(file_, folder.c_str(), kEvents | IN_ONLYDIR) < 0 && errno == ENOSPC)
        return cannotWatch(folder);
    std::error_code error;
    if (!deep) return {};
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        std::error_code ignored;
        const bool hidden = entry.path().filename().native().starts_with('.');
        if (hidden || entry.is_symlink(ignored) || !entry.is_directory(ignored)) continue;
        if (auto added = add(entry.path().string(), true); !added) return added;
    }
    return {};
}

void FolderWatch::wait(Interrupt& interrupt, milliseconds patience) {
    const int stop = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    const auto until = Clock::now() + patience;
    {
        const BreakOff breakOff(interrupt, [stop] { eventfd_write(stop, 1); });
        std::array<pollfd, 2> files{{{file_, POLLIN, 0}, {stop, POLLIN, 0}}};
        const auto pollFor = [&](milliseconds time) {
            return !interrupt.requested() &&
                   poll(files.data(), files.size(), static_cast<int>(time.count())) > 0 &&
                   files[1].revents == 0 && drain();
        };
        bool changed = false;
        while (!changed && !interrupt.requested() && Clock::now() < until)
            changed = pollFor(std::chrono::duration_cast<milliseconds>(until - Clock::now()) +
                              milliseconds(1));
        const auto latest = Clock::now() + kLongest;
        while (changed && Clock::now() < latest) changed = pollFor(kQuiet);
    }
    close(stop);
}

bool FolderWatch::drain() const {
    std::array<char, 4096> events;
    bool any = false;
    while (read(file_, events.data(), events.size()) > 0) any = true;
    return any;
}

}  // namespace rivage::client
