#include "server/ops/supervisor.h"

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "server/ops/log.h"
#include "server/ops/signals.h"

namespace rivage::server {
namespace {

using namespace std::chrono_literals;

/// A process that lives for less than this has crashed while it started, or on its first job.
constexpr auto kQuick = 1s;
constexpr auto kLongestPause = 5000ms;

std::string signalName(int signal) {
    const char* const name = ::sigabbrev_np(signal);
    return name ? "SIG" + std::string(name) : "signal " + std::to_string(signal);
}

class Supervisor {
public:
    Supervisor(const std::function<int(Supervision&)>& serve, Supervision& shared)
        : serve_(serve), shared_(shared) {}
    int run();

private:
    void start();
    [[noreturn]] void serveInChild(pid_t parent, const sigset_t& mask) const;
    std::optional<int> reap();
    std::optional<int> ended(int status);
    std::chrono::milliseconds pauseAfterCrash();
    bool handle(int signal);
    [[nodiscard]] bool pause(std::chrono::milliseconds time);

    const std::function<int(Supervision&)>& serve_;
    Supervision& shared_;
    sigset_t waited_{};
    pid_t child_ = -1;  ///< -1 while there is none
    Clock::time_point childBegan_;
    bool everStarted_ = false;
    bool stopping_ = false;
    int quickCrashes_ = 0;  ///< in a row
};

int Supervisor::run() {
    waited_ = handledSignals();
    sigaddset(&waited_, SIGCHLD);
    std::signal(SIGCHLD, SIG_DFL);        // ignored, children would vanish without a status
    sigset_t blocked = servingSignals();  // of a child too, from its first moment
    sigaddset(&blocked, SIGCHLD);
    sigset_t before;
    ::sigprocmask(SIG_BLOCK, &blocked, &before);
    std::optional<int> code;
    start();
    while (!code) {
        const int signal = ::sigwaitinfo(&waited_, nullptr);
        if (signal == SIGCHLD)
            code = reap();
        else if (signal > 0)
            handle(signal);
    }
    ::sigprocmask(SIG_SETMASK, &before, nullptr);
    return *code;
}

void Supervisor::start() {
    std::cout.flush();  // what waits there would be printed by both
    std::fflush(nullptr);
    shared_.started = false;
    childBegan_ = Clock::now();
    const pid_t parent = ::getpid();
    const sigset_t mask = servingSignals();
    child_ = ::fork();
    if (child_ == 0) serveInChild(parent, mask);
    if (child_ < 0) {
        ++quickCrashes_;
        logWarning("cannot start a process", {{"errno", errno}});
        ::kill(parent, SIGCHLD);  // `reap` then tries again, after a pause
    }
}

void Supervisor::serveInChild(pid_t parent, const sigset_t& mask) const {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) std::_Exit(1);  // it died before it could be told to tell
    ::sigprocmask(SIG_SETMASK, &mask, nullptr);
    std::exit(serve_(shared_));
}

/// Takes the status of every process that has ended: as the first process of a container, this one
/// also has those of others. @return the exit code of the program, if it is to end
std::optional<int> Supervisor::reap() {
    std::optional<int> code;
    int status = 0;
    for (pid_t process = 0; (process = ::waitpid(-1, &status, WNOHANG)) > 0;)
        if (process == child_) code = ended(status);
    if (child_ < 0 && !code) {
        if (pause(pauseAfterCrash())) return 0;
        shared_.restarts = shared_.restarts + 1;
        start();
        if (child_ > 0)
            logInfo("restarted", {{"pid", child_}, {"restarts", shared_.restarts.load()}});
    }
    return code;
}

/// The serving process has ended. @return the exit code of the program, if it is to end too
std::optional<int> Supervisor::ended(int status) {
    const pid_t process = std::exchange(child_, -1);
    const bool killed = WIFSIGNALED(status);
    const int code = killed ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
    everStarted_ |= shared_.started;
    const bool refused = !everStarted_ && (code == 1 || code == 2);
    if (!killed && (code == 0 || refused || (stopping_ && code == 130))) return code;
    const std::chrono::duration<double> uptime = Clock::now() - childBegan_;
    logWarning("crashed", {{"pid", process},
                           {"reason", killed ? signalName(WTERMSIG(status))
                                             : "exit code " + std::to_string(code)},
                           {"uptime_s", uptime.count()},
                           {"restarts", shared_.restarts.load()}});
    if (stopping_) return code;
    quickCrashes_ = uptime < kQuick ? quickCrashes_ + 1 : 0;
    return std::nullopt;
}

std::chrono::milliseconds Supervisor::pauseAfterCrash() {
    if (quickCrashes_ < 2) return 0ms;
    return std::min(kLongestPause, 100ms * (1 << std::min(quickCrashes_ - 2, 10)));
}

/// @return whether the signal asks for the end
bool Supervisor::handle(int signal) {
    const bool stop = signal == SIGTERM || signal == SIGINT;
    stopping_ |= stop;
    if (child_ > 0) sendOn(child_, signal);
    return stop;
}

/// Waits before the next start. @return whether the end was asked for
bool Supervisor::pause(std::chrono::milliseconds time) {
    const sigset_t signals = handledSignals();
    for (const auto until = Clock::now() + time; Clock::now() < until;) {
        const std::chrono::nanoseconds left =
            std::max(0ns, std::chrono::nanoseconds(until - Clock::now()));
        const timespec wait{left.count() / 1'000'000'000, left.count() % 1'000'000'000};
        const int signal = ::sigtimedwait(&signals, nullptr, &wait);
        if (signal > 0 && handle(signal)) return true;
    }
    return false;
}

}  // namespace

int supervise(const std::function<int(Supervision&)>& serve) {
    void* const memory = ::mmap(nullptr, sizeof(Supervision), PROT_READ | PROT_WRITE,
                                MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) {
        logWarning("cannot start", {{"reason", "there is no memory to share"}});
        return 1;
    }
    auto* const shared = new (memory) Supervision;
    const int code = Supervisor(serve, *shared).run();
    ::munmap(memory, sizeof(Supervision));
    return code;
}

}  // namespace rivage::server
