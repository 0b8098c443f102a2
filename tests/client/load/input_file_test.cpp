#include "client/load/input_file.h"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "../fake_server.h"

namespace rivage::client::load {
namespace {

using namespace std::chrono_literals;

/// What reading comes to: the text, or why there is none.
std::string reading(const std::string& path, const InputBounds& bounds = {}) {
    const Interrupt interrupt;
    const auto text = readInput("mix", path, bounds, interrupt);
    return text ? *text : textOf(text.error().problem, "detail");
}

TEST_SUITE("client/load") {
    TEST_CASE("input: a file up to the limit, and no byte more") {
        const TemporaryFolder folder;
        std::ofstream(folder / "a") << "12345";
        CHECK(reading(folder / "a") == "12345");
        CHECK(reading(folder / "a", {.bytes = 5}) == "12345");
        CHECK(reading(folder / "a", {.bytes = 4}) == "it has more than 4 bytes");
        std::ofstream(folder / "empty").flush();
        CHECK(reading(folder / "empty").empty());
        CHECK(reading("/proc/self/stat", {.bytes = 4}) == "it has more than 4 bytes");
    }

    TEST_CASE("reject: what has no end or no bytes, at once") {
        const TemporaryFolder folder;
        for (const char* device : {"/dev/zero", "/dev/random", "/dev/null", "/dev/tty"}) {
            CAPTURE(device);
            const std::string fault = reading(device);
            CHECK((fault == "it is a device, not a file" ||
                   fault == "No such device or address"));  // of a terminal that is not there
        }
        CHECK(reading(folder / "") == "it is a folder");
        CHECK(reading(folder / "none") == "No such file or directory");
    }

    TEST_CASE("input: a pipe is read to its end, if it has one in time and within the limit") {
        const TemporaryFolder folder;
        const std::string pipe = folder / "pipe";
        REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
        const auto written = [&](const std::string& text) {
            return std::thread([text, pipe] {
                std::ofstream out(pipe);
                out << text.substr(0, 1) << std::flush;
                std::this_thread::sleep_for(100ms);  // the reader meets a pipe without bytes
                out << text.substr(1);
            });
        };
        std::thread writer = written("one two");
        CHECK(reading(pipe) == "one two");
        writer.join();
        const auto since = std::chrono::steady_clock::now();
        CHECK(reading(pipe, {.time = 200ms}) == "it did not end within 1 s");
        CHECK(std::chrono::steady_clock::now() - since < 5s);
        std::signal(SIGPIPE, SIG_IGN);
        writer = written(std::string(200'000, 'x'));
        CHECK(reading(pipe, {.bytes = 1000}) == "it has more than 1000 bytes");
        writer.join();
    }

    TEST_CASE("input: a stop ends the wait for a pipe") {
        const TemporaryFolder folder;
        REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0);
        Interrupt interrupt;
        interrupt.request();
        const auto text = readInput("mix", folder / "pipe", {}, interrupt);
        REQUIRE_FALSE(text);
        CHECK(text.error().exit == ExitCode::cancelled);
    }
}

}  // namespace
}  // namespace rivage::client::load
