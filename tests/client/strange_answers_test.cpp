#include <doctest/doctest.h>

#include "tests/client/fake_server.h"
#include "tests/client/run.h"

namespace rivage::client {
namespace {

constexpr const char* kNotUnderstood = "The server's answer is not understood";

/// A JSON text of arrays in arrays, `depth` deep, as the member "a".
std::string nested(std::size_t depth) {
    return R"({"a":)" + std::string(depth, '[') + std::string(depth, ']') + "}";
}

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("reject: answers that are nested too deeply") {
    FakeServer server;
    const auto deep = [](int status) {
        return [status](const httplib::Request&, httplib::Response& response) {
            response.status = status;
            response.set_content(nested(300'000), "application/json");
        };
    };
    server.http.Get("/v1/options", deep(200));
    server.http.Get("/v1/jobs", deep(200));
    server.http.Get("/v1/jobs/a", deep(200));
    server.http.Get("/v1/jobs/b", deep(500));
    server.start();
    const std::vector<std::vector<std::string>> commands{
        {"options"}, {"jobs", "list"}, {"jobs", "status", "a"}};
    for (auto command : commands) {
        CAPTURE(command.back());
        command.insert(command.end(), {"--server", server.url()});
        Run run;
        run(command);
        CHECK(run.code == ExitCode::failed);
        CHECK(run.err.str().find(kNotUnderstood) != std::string::npos);
    }
    Run refused;
    refused({"jobs", "status", "b", "--server", server.url()});
    CHECK(refused.code == ExitCode::failed);
    CHECK(refused.err.str().find("The server answered 500") != std::string::npos);
}

TEST_CASE("reject: a report that is no object") {
    const TemporaryFolder folder;
    writeFile(folder / "a.vox", "VOX");
    for (const char* report : {"7", "[1]", "\"text\"", "null"}) {
        CAPTURE(report);
        FakeServer server;
        FakeJobs jobs;
        jobs.report = report;
        jobs.addTo(server.http);
        server.start();
        for (const bool json : {false, true}) {
            Run run;
            std::vector<std::string> words{"regularize", folder / "a.vox", "--server",
                                           server.url()};
            if (json) words.emplace_back("--json");
            run(words);
            CHECK(run.code == ExitCode::failed);
            CHECK(run.err.str().find(kNotUnderstood) != std::string::npos);
        }
        CHECK(folder.entries() == 1);
    }
}

TEST_CASE("reject: a stdout that takes nothing") {
    const TemporaryFolder folder;
    writeFile(folder / "a.vox", "VOX");
    FakeServer server;
    FakeJobs jobs;
    jobs.addTo(server.http);
    server.start();
    const std::vector<std::vector<std::string>> commands{{"regularize", folder / "a.vox", "--json"},
                                                         {"jobs", "status", jobs.id}};
    for (auto command : commands) {
        CAPTURE(command.front());
        command.insert(command.end(), {"--server", server.url()});
        Run run;
        run.out.setstate(std::ios::badbit);
        run(command);
        CHECK(run.code == ExitCode::notWritten);
        CHECK(run.err.str().find("stdout cannot be written") != std::string::npos);
    }
}

TEST_CASE("reject: a list of jobs whose next page is itself") {
    FakeServer server;
    std::atomic<int> pages{0};
    server.http.Get("/v1/jobs", [&](const httplib::Request&, httplib::Response& response) {
        ++pages;
        response.set_content(R"({"jobs":[{"id":"a"}],"next":"/v1/jobs?limit=1"})",
                             "application/json");
    });
    server.start();
    Run run;
    run({"jobs", "list", "--limit", "0", "--server", server.url()});
    CHECK(run.code == ExitCode::failed);
    CHECK(run.err.str().find("goes in circles") != std::string::npos);
    CHECK(pages == 2);
}

TEST_CASE("reject: a list of jobs that goes on elsewhere, or has no end") {
    std::string many = "{}";
    for (int i = 1; i < 100'000; ++i) many += ",{}";
    std::atomic<int> pages{0};
    std::atomic<int> followed{0};
    FakeServer server;
    server.http.Get("/v1/jobs", [&](const httplib::Request& request, httplib::Response& response) {
        const bool foreign = request.has_param("state");
        const std::string next =
            foreign ? "/elsewhere" : "/v1/jobs?after=" + std::to_string(++pages);
        response.set_content(R"({"jobs":[)" + many + R"(],"next":")" + next + "\"}",
                             "application/json");
    });
    server.http.Get("/elsewhere", [&](const auto&, auto&) { ++followed; });
    server.start();
    Run elsewhere;
    elsewhere({"jobs", "list", "--limit", "0", "--state", "failed", "--server", server.url()});
    CHECK(elsewhere.code == ExitCode::failed);
    CHECK(elsewhere.err.str().find("a foreign link") != std::string::npos);
    CHECK(followed == 0);
    Run endless;
    endless({"jobs", "list", "--limit", "0", "--server", server.url()});
    CHECK(endless.code == ExitCode::failed);
    CHECK(endless.err.str().find("without an end") != std::string::npos);
    CHECK(pages == 11);
}

TEST_CASE("reject: a redirection is named, not followed") {
    FakeServer server;
    std::atomic<int> followed{0};
    server.http.Get("/version", [](const httplib::Request&, httplib::Response& response) {
        response.status = 302;
        response.set_header("Location", "/elsewhere");
    });
    server.http.Get("/elsewhere", [&](const httplib::Request&, httplib::Response& response) {
        ++followed;
        response.set_content("{}", "application/json");
    });
    server.start();
    Run run;
    run({"health", "--server", server.url()});
    CHECK(run.code == ExitCode::failed);
    CHECK(run.err.str().find("elsewhere: to /elsewhere (status 302)") != std::string::npos);
    CHECK(followed == 0);
}

TEST_CASE("reject: a file that is empty, or not what its name says, in words of files") {
    const TemporaryFolder folder;
    writeFile(folder / "a.vox", "hello");
    writeFile(folder / "empty.vox", "");
    FakeServer server;
    const auto refuse = [](const httplib::Request&, httplib::Response& response) {
        response.status = 415;
        response.set_content(R"({"title":"No format","detail":"of ours","field":"/grid"})",
                             "application/problem+json");
    };
    server.http.Post("/v1/jobs", refuse);
    server.http.Post("/v1/inspect", refuse);
    server.start();
    for (const char* command : {"regularize", "inspect"}) {
        Run run;
        run({command, folder / "a.vox", "--server", server.url()});
        CHECK(run.code == ExitCode::refused);
        CHECK(run.err.str() == "rivage: " + (folder / "a.vox") +
                                   ": This is not a MagicaVoxel file: it does not begin with "
                                   "\"VOX \"\n");
        Run empty;
        empty({command, folder / "empty.vox", "--server", server.url()});
        CHECK(empty.code == ExitCode::refused);
        CHECK(empty.err.str() == "rivage: " + (folder / "empty.vox") + ": The file is empty\n");
        Run missing;
        missing({command, folder / "none.vox", "--server", server.url()});
        CHECK(missing.code == ExitCode::usage);
        CHECK(missing.err.str() == "rivage: " + (folder / "none.vox") +
                                       ": The input cannot be read: No such file or directory\n");
    }
}

TEST_CASE("reject: --help and its like when stdout takes nothing") {
    for (const char* word : {"--help", "--version", "man"}) {
        CAPTURE(word);
        Run run;
        run.out.setstate(std::ios::badbit);
        run({word});
        CHECK(run.code == ExitCode::notWritten);
        CHECK(run.err.str() == "rivage: stdout cannot be written\n");
    }
}

TEST_CASE("jobs: numbers of a server that are none of a job") {
    FakeServer server;
    server.http.Get("/v1/jobs/a", [](const httplib::Request&, httplib::Response& response) {
        response.set_content(
            R"({"id":"a","state":"queued","progress":1e308,"queue_position":-1e300,"created":7})",
            "application/json");
    });
    server.http.Get("/v1/jobs/b", [](const httplib::Request&, httplib::Response& response) {
        response.set_content(R"({"id":"b","state":"queued","progress":-7,"queue_position":1e300})",
                             "application/json");
    });
    server.start();
    Run run;
    run({"jobs", "status", "a", "b", "--server", server.url()});
    CHECK(run.code == ExitCode::ok);
    CHECK(run.out.str().find("100 %") != std::string::npos);
    CHECK(run.out.str().find("-1e+300 ahead") != std::string::npos);
    CHECK(run.out.str().find("  0 %") != std::string::npos);
    CHECK(run.out.str().find(" 1e+300 ahead") != std::string::npos);
}

TEST_SUITE_END();

}  // namespace rivage::client
