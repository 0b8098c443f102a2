#include <doctest/doctest.h>

#include <functional>
#include <thread>

#include "client/folder_watch.h"
#include "tests/client/fake_server.h"
#include "tests/client/run.h"

namespace rivage::client {
namespace {

using namespace std::chrono_literals;

/// `regularize --watch` over a folder, in a thread of its own.
struct WatchedFolder {
    TemporaryFolder folder;
    FakeServer server;
    FakeJobs jobs;
    Run run;
    std::thread thread;

    WatchedFolder() {
        std::filesystem::create_directory(folder / "in");
        writeFile(folder / "in/a.vox", "first");
        jobs.addTo(server.http);
        server.start();
    }
    ~WatchedFolder() { stop(); }
    void start() {
        thread = std::thread([this] {
            run({"regularize", folder / "in", "-o", folder / "out", "--watch", "--server",
                 server.url()});
        });
    }
    void stop() {
        run.interrupt.request();
        if (thread.joinable()) thread.join();
    }
    [[nodiscard]] static bool comes(const std::function<bool()>& what) {
        for (int i = 0; i < 500; ++i) {
            if (what()) return true;
            std::this_thread::sleep_for(10ms);
        }
        return false;
    }
    [[nodiscard]] bool converted(int number) const {
        return comes([&] { return jobs.posts == number; });
    }
    /// Waits long enough for a conversion too many to show.
    [[nodiscard]] int postsLater() const {
        std::this_thread::sleep_for(400ms);
        return jobs.posts;
    }
};

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("watch: all once, then what changes, by whatever way an editor writes") {
    WatchedFolder watched;
    watched.start();
    REQUIRE(watched.converted(1));
    CHECK(watched.postsLater() == 1);  // its own result does not wake it

    writeFile(watched.folder / "in/a.vox", "written in place");
    REQUIRE(watched.converted(2));
    writeFile(watched.folder / "in/.a.vox.tmp", "renamed into place");
    std::filesystem::rename(watched.folder / "in/.a.vox.tmp", watched.folder / "in/a.vox");
    REQUIRE(watched.converted(3));
    CHECK(watched.jobs.lastBody() == "renamed into place");

    writeFile(watched.folder / "in/new.vox", "new");
    REQUIRE(watched.converted(4));
    std::filesystem::create_directories(watched.folder / "in/x/y");
    writeFile(watched.folder / "in/x/y/deep.vox", "deep");
    REQUIRE(watched.converted(5));
    REQUIRE(WatchedFolder::comes(
        [&] { return std::filesystem::exists(watched.folder / "out/x/y/deep.glb"); }));
    writeFile(watched.folder / "in/x/y/deep.vox", "deeper");
    REQUIRE(watched.converted(6));

    std::filesystem::remove(watched.folder / "in/new.vox");
    std::filesystem::remove_all(watched.folder / "in/x");
    writeFile(watched.folder / "in/notes.txt", "no grid");
    CHECK(watched.postsLater() == 6);
    watched.stop();
    CHECK(watched.run.code == ExitCode::ok);
}

TEST_CASE("watch: goes on after a conversion that failed, and after a plan that cannot be") {
    WatchedFolder watched;
    watched.jobs.become("failed", R"({"title":"It is bad","status":422})");
    watched.start();
    REQUIRE(watched.converted(1));
    CHECK(watched.postsLater() == 1);  // not again until it changes
    watched.jobs.become("succeeded");
    writeFile(watched.folder / "in/a.npy", "two for one result");
    CHECK(watched.postsLater() == 1);
    std::filesystem::remove(watched.folder / "in/a.npy");
    writeFile(watched.folder / "in/a.vox", "better");
    REQUIRE(watched.converted(2));
    REQUIRE(WatchedFolder::comes(
        [&] { return std::filesystem::exists(watched.folder / "out/a.glb"); }));
    watched.stop();
    CHECK(watched.run.code == ExitCode::ok);
    CHECK(watched.run.err.str().find("It is bad") != std::string::npos);
    CHECK(watched.run.err.str().find("would both be written") != std::string::npos);
}

TEST_CASE("watch: a stop in the middle of a conversion cancels it") {
    WatchedFolder watched;
    watched.jobs.become("running");
    watched.start();
    REQUIRE(WatchedFolder::comes([&] { return watched.jobs.polls > 0; }));
    watched.stop();
    CHECK(watched.run.code == ExitCode::cancelled);
    CHECK(watched.jobs.deletes == 1);
}

TEST_CASE("reject: stdin and stdout cannot be watched") {
    Run run;
    CHECK(run({"regularize", "-", "--watch"}).code == ExitCode::usage);
}

TEST_CASE("folder watch: a stop ends the waiting, and so does its patience") {
    const TemporaryFolder folder;
    auto watch = FolderWatch::open();
    REQUIRE(watch);
    REQUIRE(watch->add(folder / "", true));
    Interrupt interrupt;
    const auto start = std::chrono::steady_clock::now();
    watch->wait(interrupt, 50ms);
    CHECK(std::chrono::steady_clock::now() - start >= 50ms);
    std::thread person([&] {
        std::this_thread::sleep_for(50ms);
        interrupt.request();
    });
    watch->wait(interrupt, 60s);
    person.join();
    CHECK(std::chrono::steady_clock::now() - start < 10s);
}

TEST_SUITE_END();

}  // namespace rivage::client
