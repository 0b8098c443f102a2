#include "server/jobs/crash_board.h"

#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <thread>
#include <vector>

#include "server/jobs/digest.h"
#include "tests/support/temporary_folder.h"

using namespace rivage;
using namespace rivage::server;
using namespace std::chrono_literals;

namespace {

std::string hexOf(const std::string& text) { return sha256(std::as_bytes(std::span(text))).hex; }

std::unique_ptr<CrashBoard> openBoard(const std::string& path, std::chrono::seconds ttl = 1h) {
    auto board = CrashBoard::open(path, ttl);
    REQUIRE(board);
    return *std::move(board);
}

/// Runs something in a process that is then killed.
template <typename Work>
void inKilledProcess(Work work) {
    const pid_t child = ::fork();
    if (child == 0) {
        work();
        ::kill(::getpid(), SIGKILL);
    }
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    REQUIRE(WIFSIGNALED(status));
}

}  // namespace

TEST_SUITE_BEGIN("server/jobs");

TEST_CASE("crash board: what ran when a process died has one crash more, what had ended has none") {
    for (const bool inFile : {false, true}) {
        CAPTURE(inFile);
        const test::TemporaryFolder folder;
        const std::string path = inFile ? folder.path() + "/crashes" : "";
        auto board = openBoard(path);
        for (int crash = 1; crash <= 2; ++crash) {
            inKilledProcess([&] {
                board->begin(0, hexOf("ended"));
                board->begin(1, hexOf("running"));
                board->end(0);
            });
            CHECK(board->recover() == 1);
            CHECK(board->crashes(hexOf("running")) == crash);
        }
        CHECK(board->crashes(hexOf("ended")) == 0);
        CHECK(board->recover() == 0);
        CHECK(board->crashes(hexOf("running")) == 2);
        if (inFile) CHECK(openBoard(path)->crashes(hexOf("running")) == 2);
    }
}

TEST_CASE("crash board: after a normal end an input counts from 0 again") {
    const auto board = openBoard("");
    const std::string hex = hexOf("a");
    board->begin(7, hex);
    CHECK(board->recover() == 1);
    CHECK(board->crashes(hex) == 1);
    board->begin(3, hex);
    board->end(3);
    CHECK(board->crashes(hex) == 0);
}

TEST_CASE("crash board: an accused input alone has the crash") {
    const auto board = openBoard("");
    board->begin(0, hexOf("bystander"));
    board->begin(1, hexOf("culprit"));
    board->accuse(1);
    board->accuse(2);  // nothing runs there
    CHECK(board->recover() == 1);
    CHECK(board->crashes(hexOf("bystander")) == 0);
    CHECK(board->crashes(hexOf("culprit")) == 1);
}

TEST_CASE("crash board: an end on purpose is no crash, an input in two slots crashes once") {
    const auto board = openBoard("");
    board->begin(0, hexOf("a"));
    board->clear();
    CHECK(board->recover() == 0);
    board->begin(0, hexOf("a"));
    board->begin(1, hexOf("a"));
    CHECK(board->recover() == 1);
    CHECK(board->crashes(hexOf("a")) == 1);
}

TEST_CASE("crash board: crashes are forgotten after the quarantine") {
    const test::TemporaryFolder folder;
    const std::string path = folder.path() + "/crashes";
    {
        const auto board = openBoard(path);
        board->begin(0, hexOf("a"));
        board->recover();
    }
    const auto board = openBoard(path, 0s);
    CHECK(board->crashes(hexOf("a")) == 0);
    board->begin(0, hexOf("a"));
    board->recover();
    CHECK(openBoard(path)->crashes(hexOf("a")) == 1);
}

TEST_CASE("crash board: one crash more than it has places drops the oldest only") {
    const auto board = openBoard("");
    for (std::size_t i = 0; i < CrashBoard::kInputs; ++i) {
        board->begin(0, hexOf(std::to_string(i)));
        board->recover();
    }
    const auto known = [&] {
        int sum = 0;
        for (std::size_t i = 0; i < CrashBoard::kInputs; ++i)
            sum += board->crashes(hexOf(std::to_string(i)));
        return sum;
    };
    CHECK(known() == CrashBoard::kInputs);
    board->begin(0, hexOf("500"));
    board->end(0);
    for (const int left : {1, 2}) {  // the first takes the place that is free again
        board->begin(0, hexOf("more" + std::to_string(left)));
        board->recover();
        CHECK(known() == static_cast<int>(CrashBoard::kInputs) - left);
        CHECK(board->crashes(hexOf("more" + std::to_string(left))) == 1);
    }
}

TEST_CASE("crash board: a damaged file is begun anew") {
    const test::TemporaryFolder folder;
    const std::string path = folder.path() + "/crashes";
    {
        const auto board = openBoard(path);
        board->begin(0, hexOf("a"));
    }
    const std::string whole = test::readFile(path);
    for (const std::string& bytes : {std::string(), whole.substr(1), "x" + whole.substr(1),
                                     whole + "x", std::string(whole.size(), '\xff')}) {
        test::writeFile(path, bytes);
        const auto board = openBoard(path);
        CHECK(board->recover() == 0);
        board->begin(0, hexOf("b"));
        CHECK(board->recover() == 1);
        CHECK(board->crashes(hexOf("a")) == 0);
        CHECK(test::readFile(path).size() == whole.size());
    }
    test::writeFile(path, whole);
    CHECK(openBoard(path)->recover() == 1);
}

// Kills a process at some instant of its writing, many times: only inputs that it ever ran are
// found, each at most once.
TEST_CASE("property: a crash at any instant leaves whole digests") {
    const auto board = openBoard("");
    for (int cycle = 0; cycle < 30; ++cycle) {
        const pid_t child = ::fork();
        if (child == 0) {
            const std::string digests[] = {hexOf("x"), hexOf("y")};
            for (unsigned i = 0;; ++i) {
                board->begin(i % 3, digests[i % 2]);
                if (i % 5 == 0) board->end(i % 3);
            }
        }
        ::usleep(500 + 131 * cycle);
        ::kill(child, SIGKILL);
        int status = 0;
        REQUIRE(::waitpid(child, &status, 0) == child);
        const int before = board->crashes(hexOf("x")) + board->crashes(hexOf("y"));
        const std::size_t counted = board->recover();
        CHECK(counted <= 2);
        const int after = board->crashes(hexOf("x")) + board->crashes(hexOf("y"));
        CHECK(after - before == static_cast<int>(counted));
    }
}

TEST_CASE("crash board: workers do not disturb each other") {
    const auto board = openBoard("");
    std::vector<std::thread> workers;
    for (std::size_t slot = 0; slot < 4; ++slot)
        workers.emplace_back([&, slot] {
            for (int i = 0; i < 200; ++i) {
                board->begin(slot, hexOf(std::to_string(slot)));
                if (i < 199) board->end(slot);
            }
        });
    for (std::thread& worker : workers) worker.join();
    CHECK(board->recover() == 4);
}

TEST_SUITE_END();
