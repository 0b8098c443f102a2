#include "server/ops/supervisor.h"

#include <doctest/doctest.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <new>
#include <thread>

#include "server/ops/log.h"
#include "server/ops/signals.h"

using namespace rivage::server;
using namespace std::chrono_literals;

namespace {

/// What the processes of a test tell each other.
struct Board {
    std::atomic<int> lives{0};
    std::atomic<int> restarts{0};
    std::atomic<int> requests{0};
    std::atomic<pid_t> serving{0};
    std::array<std::atomic<long>, 5> begun{};  ///< when each life began, in ms
    std::atomic<long> crashed{0};              ///< when the last crash came, in ms
};

/// The same clock for all processes.
long milliseconds() { return std::chrono::steady_clock::now().time_since_epoch() / 1ms; }

class Shared {
public:
    Shared()
        : board_(new (::mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE,
                             MAP_SHARED | MAP_ANONYMOUS, -1, 0)) Board) {}
    ~Shared() { ::munmap(board_, sizeof(Board)); }
    Shared(const Shared&) = delete;
    Shared& operator=(const Shared&) = delete;
    Board* operator->() const { return board_; }

private:
    Board* board_;
};

/// A supervisor in a process of its own, as the program would be.
class Program {
public:
    explicit Program(const std::function<int(Supervision&)>& serve) {
        std::cout.flush();  // what waits there would be printed by both
        process_ = ::fork();
        if (process_ != 0) return;
        for (const int signal : {SIGSEGV, SIGABRT}) std::signal(signal, SIG_DFL);  // not doctest's
        setUpLog(LogFormat::text, "off");
        ::_exit(supervise(serve));
    }
    ~Program() {
        if (process_ > 0) ::kill(process_, SIGKILL);
        if (process_ > 0) code();
    }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;
    void send(int signal) const { ::kill(process_, signal); }
    int code() {
        int status = 0;
        ::waitpid(std::exchange(process_, -1), &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }

private:
    pid_t process_;
};

template <typename Condition>
bool soon(Condition condition) {
    for (int i = 0; i < 10000 && !condition(); ++i) std::this_thread::sleep_for(1ms);
    return condition();
}

/// Serves until a signal asks for the end.
int serveUntilAsked(Supervision& supervision, const Shared& shared) {
    SignalReader signals;
    supervision.started = true;
    shared->serving = ::getpid();
    ++shared->lives;
    while (true) {
        const SignalRequest request = signals.next(10s);
        ++shared->requests;
        if (request == SignalRequest::none) return 99;
        if (request == SignalRequest::end) return 130;
        if (request == SignalRequest::stopSoon) return 0;
    }
}

/// How long a process of this size takes to begin and to be gone: with a sanitizer, as long as the
/// pauses in question. In ms.
long processCost() {
    const long begin = milliseconds();
    const pid_t process = ::fork();
    if (process == 0) ::raise(SIGKILL);
    ::waitpid(process, nullptr, 0);
    return milliseconds() - begin;
}

/// Between the lives of a process that is killed at once, in ms.
std::array<long, 4> pausesOfFiveLives() {
    const Shared shared;
    Program program([&](Supervision&) {
        const int life = shared->lives++;
        shared->begun[life] = milliseconds();
        if (life < 4) ::raise(SIGKILL);
        return 0;
    });
    CHECK(program.code() == 0);
    std::array<long, 4> pauses{};
    for (std::size_t i = 0; i < pauses.size(); ++i)
        pauses[i] = shared->begun[i + 1] - shared->begun[i];
    return pauses;
}

/// With the signals of a serving process blocked; what still waits at the end is dropped.
class Serving {
public:
    Serving() {
        const sigset_t signals = servingSignals();
        ::pthread_sigmask(SIG_BLOCK, &signals, &before_);
    }
    ~Serving() {
        const sigset_t signals = servingSignals();
        const timespec none{};
        while (::sigtimedwait(&signals, nullptr, &none) > 0) continue;
        ::pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    }
    Serving(const Serving&) = delete;
    Serving& operator=(const Serving&) = delete;

private:
    sigset_t before_{};
};

}  // namespace

TEST_SUITE_BEGIN("server/ops");

TEST_CASE("supervisor: a process that ends by itself, or cannot start, ends the program") {
    for (const int code : {0, 1, 2}) {
        CAPTURE(code);
        const Shared shared;
        Program program([&](Supervision&) {
            ++shared->lives;
            return code;
        });
        CHECK(program.code() == code);
        CHECK(shared->lives == 1);
    }
}

TEST_CASE("supervisor: after a signal or a wrong code it serves again within a second") {
    for (const int how : {SIGSEGV, SIGKILL, SIGABRT, -1, -70}) {
        CAPTURE(how);
        const Shared shared;
        Program program([&](Supervision& supervision) {
            supervision.started = true;
            shared->restarts = static_cast<int>(supervision.restarts);
            const int life = shared->lives++;
            shared->begun[life] = milliseconds();
            if (life == 1) return 0;
            shared->crashed = milliseconds();
            if (how > 0) ::raise(how);
            return -how;
        });
        CHECK(program.code() == 0);
        CHECK(shared->begun[1] - shared->crashed < 1000);
        CHECK(shared->lives == 2);
        CHECK(shared->restarts == 1);
    }
}

TEST_CASE("supervisor: quick crashes in a row are spaced out, the first is not") {
    constexpr std::array<long, 4> kLeast = {0, 100, 200, 400};
    const long most = 90 + processCost();
    std::array<long, 4> shortest = pausesOfFiveLives();
    const auto tooLong = [&](std::size_t i) { return shortest[i] >= kLeast[i] + most; };
    // A busy machine adds to some pauses, but not to the same ones each time.
    for (int again = 0; again < 4 && (tooLong(0) || tooLong(1) || tooLong(2) || tooLong(3));
         ++again)
        std::ranges::transform(shortest, pausesOfFiveLives(), shortest.begin(),
                               [](long a, long b) { return std::min(a, b); });
    for (std::size_t i = 0; i < kLeast.size(); ++i) {
        CAPTURE(i);
        CHECK(shortest[i] >= kLeast[i]);
        CHECK(shortest[i] < kLeast[i] + most);
    }
}

TEST_CASE("supervisor: signals go on; a second stop signal ends at once") {
    const Shared shared;
    Program program([&](Supervision& s) { return serveUntilAsked(s, shared); });
    REQUIRE(soon([&] { return shared->lives == 1; }));
    program.send(SIGHUP);
    CHECK(soon([&] { return shared->requests == 1; }));
    program.send(SIGTERM);
    CHECK(soon([&] { return shared->requests == 2; }));
    program.send(SIGTERM);
    CHECK(program.code() == 130);
    CHECK(shared->lives == 1);
}

TEST_CASE("supervisor: a signal to the whole group is one request") {
    const Shared shared;
    Program program([&](Supervision& s) { return serveUntilAsked(s, shared); });
    REQUIRE(soon([&] { return shared->lives == 1; }));
    ::kill(shared->serving, SIGTERM);  // as systemd sends it to both
    program.send(SIGTERM);
    CHECK(soon([&] { return shared->requests == 1; }));
    std::this_thread::sleep_for(50ms);
    CHECK(shared->requests == 1);
    program.send(SIGTERM);
    ::kill(shared->serving, SIGTERM);
    CHECK(program.code() == 130);
}

TEST_CASE("supervisor: a crash while it stops is the end") {
    const Shared shared;
    Program program([&](Supervision& supervision) {
        supervision.started = true;
        ++shared->lives;
        if (SignalReader().next(10s) == SignalRequest::stop) ::raise(SIGSEGV);
        return 0;
    });
    REQUIRE(soon([&] { return shared->lives == 1; }));
    program.send(SIGTERM);
    CHECK(program.code() == 128 + SIGSEGV);
    CHECK(shared->lives == 1);
}

TEST_CASE("supervisor: a stop signal ends a pause between crashes") {
    const Shared shared;
    Program program([&](Supervision&) {
        shared->serving = ::getpid();
        ++shared->lives;
        ::raise(SIGKILL);
        return 0;
    });
    REQUIRE(soon([&] { return shared->lives == 6; }));  // the next pause takes 1.6 s
    // It begins when the supervisor has taken the status of the process.
    REQUIRE(soon([&] { return ::kill(shared->serving, 0) != 0; }));
    const auto begin = std::chrono::steady_clock::now();
    program.send(SIGTERM);
    CHECK(program.code() == 0);
    CHECK(std::chrono::steady_clock::now() - begin < 500ms);
}

TEST_CASE("supervisor: the serving process dies with it") {
    const Shared shared;
    int pipe[2];
    REQUIRE(::pipe(pipe) == 0);
    Program program([&](Supervision& s) { return serveUntilAsked(s, shared); });
    REQUIRE(soon([&] { return shared->lives == 1; }));
    ::close(pipe[1]);
    pollfd end{pipe[0], POLLIN, 0};
    CHECK(::poll(&end, 1, 50) == 0);
    program.send(SIGKILL);
    CHECK(program.code() == -SIGKILL);
    CHECK(::poll(&end, 1, 2000) == 1);  // nobody holds the other end any more
    ::close(pipe[0]);
}

TEST_CASE("signals: without a supervisor each stop signal counts") {
    const Serving serving;
    SignalReader reader;
    CHECK(reader.next(1ms) == SignalRequest::none);
    ::kill(::getpid(), SIGHUP);
    CHECK(reader.next(1s) == SignalRequest::reload);
    ::kill(::getpid(), SIGINT);
    CHECK(reader.next(1s) == SignalRequest::stopSoon);
    ::kill(::getpid(), SIGTERM);
    CHECK(reader.next(1s) == SignalRequest::end);
}

TEST_CASE("regression: a second stop was lost if the two signals of one request became one") {
    const Serving serving;
    SignalReader reader;
    ::kill(::getpid(), SIGTERM);
    CHECK(reader.next(1s) == SignalRequest::stop);
    sendOn(::getpid(), SIGTERM);
    CHECK(reader.next(1ms) == SignalRequest::none);
    sendOn(::getpid(), SIGTERM);
    ::kill(::getpid(), SIGTERM);
    CHECK(reader.next(1s) == SignalRequest::end);
}

TEST_SUITE_END();
