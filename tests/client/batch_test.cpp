#include <doctest/doctest.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <mutex>
#include <new>
#include <streambuf>
#include <thread>

#include "client/plan.h"
#include "tests/client/fake_server.h"
#include "tests/client/run.h"

namespace rivage::client {
namespace {

using namespace std::chrono_literals;

/// A server that gives each grid back as its own result; a grid "bad" fails, one "slow" takes time.
struct Mirror {
    FakeServer server;
    std::atomic<int> running{0};
    std::atomic<int> most{0};
    std::atomic<int> posts{0};

    Mirror() {
        server.http.Post("/v1/jobs", [this](const httplib::Request& request, auto& response) {
            const int now = ++running;
            for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) {
            }
            const std::lock_guard lock(mutex_);
            const std::string id = "job-" + std::to_string(++posts);
            grids_[id] = request.body;
            response.status = 202;
            response.set_content(job(id), "application/json");
        });
        server.http.Get(R"(/v1/jobs/(job-\d+))", [this](const auto& request, auto& response) {
            const std::lock_guard lock(mutex_);
            response.set_content(job(request.matches[1]), "application/json");
        });
        server.http.Get(R"(/v1/jobs/(job-\d+)/result)",
                        [this](const auto& request, auto& response) {
                            std::this_thread::sleep_for(20ms);
                            --running;
                            const std::lock_guard lock(mutex_);
                            response.set_content(grids_[request.matches[1]], "model/gltf-binary");
                        });
        server.start();
    }

private:
    std::string job(const std::string& id) {
        const bool bad = grids_[id] == "bad";
        if (bad && !failed_[id]) --running;
        if (bad) failed_[id] = true;
        return R"({"id":")" + id + R"(","state":")" + (bad ? "failed" : "succeeded") +
               R"(","report":{},"error":{"title":"It is bad","status":422}})";
    }
    std::mutex mutex_;
    std::map<std::string, std::string> grids_;
    std::map<std::string, bool> failed_;
};

struct Models {
    TemporaryFolder folder;
    Mirror mirror;
    Models() {
        std::filesystem::create_directories(folder / "in/deep");
        for (const char* name : {"a", "b", "deep/c", "deep/d"})
            writeFile(folder / ("in/" + std::string(name) + ".vox"), name);
    }
    Run& regularize(Run& run, std::vector<std::string> more) const {
        std::vector<std::string> all{"regularize", "--server", mirror.server.url()};
        all.insert(all.end(), more.begin(), more.end());
        return run(all);
    }
};

std::vector<proto::Json> lines(const std::string& text) {
    std::vector<proto::Json> found;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) found.push_back(proto::Json::parse(line));
    return found;
}

bool says(const Run& run, const std::string& text) {
    return run.err.str().find(text) != std::string::npos;
}

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("batch: a folder is mirrored, several at a time, with a summary") {
    Models models;
    Run run;
    models.regularize(run, {models.folder / "in", "-o", models.folder / "out", "-w", "3"});
    CHECK(run.code == ExitCode::ok);
    for (const char* name : {"a", "b", "deep/c", "deep/d"})
        CHECK(contentOf(models.folder / ("out/" + std::string(name) + ".glb")) == name);
    CHECK(models.mirror.most > 1);
    CHECK(models.mirror.most <= 3);
    CHECK(says(run, "4 converted; 14 B in"));
    const std::string words = run.err.str();
    CHECK(std::count(words.begin(), words.end(), '\n') == 5);
}

TEST_CASE("batch: without -o the results land beside their inputs") {
    Models models;
    Run run;
    models.regularize(run, {models.folder / "in"});
    CHECK(run.code == ExitCode::ok);
    CHECK(contentOf(models.folder / "in/deep/c.glb") == "deep/c");
}

TEST_CASE("batch: --json has a line for each, with its input and output") {
    Models models;
    writeFile(models.folder / "in/b.vox", "bad");
    Run run;
    models.regularize(run, {models.folder / "in", "-o", models.folder / "out", "--json"});
    CHECK(run.code == ExitCode::refused);
    const auto all = lines(run.out.str());
    REQUIRE(all.size() == 4);
    int failed = 0;
    for (const proto::Json& line : all) {
        const std::string input = line["run"]["input"];
        CHECK(input.starts_with(models.folder / "in/"));
        CHECK(line["run"]["output"].get<std::string>().starts_with(models.folder / "out/"));
        if (!line["run"].contains("exit")) continue;
        ++failed;
        CHECK(input == models.folder / "in/b.vox");
        CHECK(line["title"] == "It is bad");
        CHECK(line["run"]["exit"] == 3);
    }
    CHECK(failed == 1);
}

TEST_CASE("batch: the others are converted when one fails, unless --stop-on-error") {
    Models models;
    writeFile(models.folder / "in/a.vox", "bad");
    Run run;
    models.regularize(run, {models.folder / "in", "-o", models.folder / "out"});
    CHECK(run.code == ExitCode::refused);
    CHECK(says(run, "3 converted, 1 failed"));
    CHECK_FALSE(std::filesystem::exists(models.folder / "out/a.glb"));
    CHECK(contentOf(models.folder / "out/b.glb") == "b");

    Run stopping;
    models.regularize(stopping, {models.folder / "in", "-o", models.folder / "out2",
                                 "--stop-on-error", "-w", "1"});
    CHECK(stopping.code == ExitCode::refused);
    CHECK(says(stopping, "0 converted, 1 failed, 3 not tried"));
}

TEST_CASE("batch: --if-newer passes over what is up to date") {
    Models models;
    const std::vector<std::string> arguments{
        models.folder / "in", "-o", models.folder / "out", "--if-newer", "--output", "obj"};
    Run first;
    models.regularize(first, arguments);
    CHECK(models.mirror.posts == 4);
    namespace fs = std::filesystem;
    const auto later = fs::last_write_time(models.folder / "out/b.obj") + 10s;
    fs::last_write_time(models.folder / "in/b.vox", later);
    Run second;
    models.regularize(second, arguments);
    CHECK(second.code == ExitCode::ok);
    CHECK(models.mirror.posts == 5);
    CHECK(says(second, "1 converted, 3 up to date"));
    CHECK_FALSE(says(second, "in/a.vox"));
    Run third;
    models.regularize(third, {models.folder / "in/a.vox", "-o", models.folder / "out/",
                              "--if-newer", "--output", "obj"});
    CHECK(says(third, "0 converted, 1 up to date"));
}

TEST_CASE("batch: a stop ends the waiting for who writes to a pipe") {
    Models models;
    const std::string pipe = models.folder / "pipe.vox";
    REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
    Run run;
    std::thread person([&] {
        std::this_thread::sleep_for(100ms);
        run.interrupt.request();
    });
    models.regularize(run, {pipe, "-o", models.folder / "x.glb"});
    person.join();
    CHECK(run.code == ExitCode::cancelled);
    Run fed;
    std::thread writer([&] { writeFile(pipe, "from a pipe"); });
    models.regularize(fed, {pipe, "-o", models.folder / "x.glb"});
    writer.join();
    CHECK(fed.code == ExitCode::ok);
    CHECK(contentOf(models.folder / "x.glb") == "from a pipe");
}

/// What breaks off in the middle of a read, as memory that runs out does.
class Broken : public std::streambuf {
    int_type underflow() override { throw std::bad_alloc(); }
};

TEST_CASE("batch: an exception is the end of its file, not of the others") {
    Models models;
    Broken broken;
    Run run;
    static_cast<std::ios&>(run.in).rdbuf(&broken);
    run.in.exceptions(std::ios::badbit);
    models.regularize(run, {"-", models.folder / "in", "-o", models.folder / "out/", "--json"});
    CHECK(run.code == ExitCode::failed);
    CHECK(says(run, "-: There is not enough memory"));
    CHECK(says(run, "4 converted, 1 failed"));
    CHECK(run.out.str().find("\"exit\":6") != std::string::npos);
}

TEST_CASE("batch: a folder that cannot be searched ends with 2, after the others") {
    Models models;
    std::filesystem::create_symlink("loop.vox", models.folder / "in/loop.vox");
    Run run;
    models.regularize(run, {models.folder / "in", "-o", models.folder / "out"});
    CHECK(run.code == ExitCode::usage);
    CHECK(says(run, "in/loop.vox: It cannot be read, and is left out"));
    CHECK(says(run, "4 converted"));
}

TEST_CASE("reject: two results in one place, before anything is sent") {
    Models models;
    writeFile(models.folder / "in/a.npy", "npy");
    Run run;
    models.regularize(run, {models.folder / "in", "-o", models.folder / "out"});
    CHECK(run.code == ExitCode::usage);
    CHECK(says(run, "in/a.npy and"));
    CHECK(models.mirror.posts == 0);
    CHECK_FALSE(std::filesystem::exists(models.folder / "out"));
}

TEST_CASE("batch: a server that is not there ends it at once") {
    Models models;
    Run run;
    run({"regularize", models.folder / "in", "-o", models.folder / "out", "-w", "1", "--server",
         "http://127.0.0.1:1"});
    CHECK(run.code == ExitCode::unreachable);
    CHECK(says(run, "0 converted, 1 failed, 3 not tried"));
}

TEST_CASE("batch: a stop leaves what is done and begins nothing") {
    Models models;
    for (int i = 0; i < 100; ++i)
        writeFile(models.folder / ("in/more" + std::to_string(i) + ".vox"), "more");
    Run run;
    std::thread person([&] {
        while (models.mirror.posts < 5) std::this_thread::sleep_for(1ms);
        run.interrupt.request();
    });
    models.regularize(run, {models.folder / "in", "-o", models.folder / "out"});
    person.join();
    CHECK(run.code == ExitCode::cancelled);
    CHECK(models.mirror.posts < 50);
    for (const auto& file : std::filesystem::recursive_directory_iterator(models.folder / "out"))
        if (file.is_regular_file()) CHECK(file.path().extension() == ".glb");
}

TEST_SUITE_END();

}  // namespace rivage::client
