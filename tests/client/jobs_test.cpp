#include <doctest/doctest.h>

#include <map>

#include "tests/client/fake_server.h"
#include "tests/client/run.h"

namespace rivage::client {
namespace {

/// A server with five jobs in five states, of which it lists two a page.
struct JobServer {
    TemporaryFolder folder;
    FakeServer server;
    std::map<std::string, std::string> states{{"job-1", "running"},
                                              {"job-2", "queued"},
                                              {"job-3", "succeeded"},
                                              {"job-4", "failed"},
                                              {"job-5", "canceled"}};
    std::vector<std::string> deleted;
    int polls = 0;
    std::string lastList;

    JobServer() {
        server.http.Get("/v1/jobs", [this](const httplib::Request& request, auto& response) {
            lastList = request.target;
            list(request.get_param_value("after"), response);
        });
        server.http.Get(R"(/v1/jobs/(job-\d))", [this](const auto& request, auto& response) {
            const std::string id = request.matches[1];
            // A job that runs ends when it is asked for the third time.
            if (states[id] == "running" && ++polls == 3) states[id] = "succeeded";
            response.set_content(job(id), "application/json");
        });
        server.http.Get(R"(/v1/jobs/(job-\d)/result)", [](const auto& request, auto& response) {
            response.set_content("result of " + std::string(request.matches[1]),
                                 "model/gltf-binary");
        });
        server.http.Delete(R"(/v1/jobs/(job-\d))", [this](const auto& request, auto& response) {
            deleted.push_back(request.matches[1]);
            response.status = 204;
        });
        server.start();
    }
    Run& jobs(Run& run, std::vector<std::string> more) const {
        more.insert(more.begin(), "jobs");
        more.insert(more.end(), {"--server", server.url()});
        return run(more);
    }

private:
    std::string job(const std::string& id) {
        return R"({"id":")" + id + R"(","name":"house","state":")" + states[id] +
               R"(","stage":"solve","progress":0.5,"created":"2026-01-02T03:04:05.678Z",)" +
               R"("options":{"output":"obj"},"report":{"a":1},)" +
               R"("error":{"title":"It is bad","status":422}})";
    }
    void list(const std::string& after, httplib::Response& response) {
        std::string page;
        std::string last;
        int count = 0;
        for (auto it = states.upper_bound(after); it != states.end() && count < 2; ++it, ++count) {
            page += (page.empty() ? "" : ",") + job(it->first);
            last = it->first;
        }
        const std::string next =
            count == 2 ? "\"/v1/jobs?limit=2&after=" + last + "\"" : std::string("null");
        response.set_content(R"({"jobs":[)" + page + R"(],"next":)" + next + "}",
                             "application/json");
    }
};

std::size_t lineCount(const std::string& text) {
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("jobs list: pages, limit, state") {
    JobServer server;
    const auto listed = [&](std::vector<std::string> more) {
        Run run;
        more.insert(more.begin(), "list");
        server.jobs(run, more);
        CHECK(run.code == ExitCode::ok);
        return run.out.str();
    };
    CHECK(lineCount(listed({})) == 5);
    CHECK(lineCount(listed({"--limit", "3"})) == 3);
    CHECK(lineCount(listed({"--limit", "0"})) == 5);
    CHECK(listed({}).find("job-1") != std::string::npos);
    CHECK(listed({}).find("2026-01-02T03:04:05") != std::string::npos);
    CHECK(listed({}).find("2026-01-02T03:04:05Z") != std::string::npos);
    CHECK(listed({}).find("04:05Z  house  It is bad\n") != std::string::npos);
    CHECK(listed({}).find("CREATED") == std::string::npos);
    listed({"--state", "failed", "--limit", "1"});
    CHECK(server.lastList == "/v1/jobs?limit=1&state=failed");
    std::istringstream lines(listed({"--json"}));
    std::string line;
    std::getline(lines, line);
    CHECK(proto::Json::parse(line)["id"] == "job-1");
    Run run;
    CHECK(server.jobs(run, {"list", "--state", "done"}).code == ExitCode::usage);
}

TEST_CASE("jobs list: a head for a person, none for a program") {
    JobServer server;
    for (const bool json : {false, true}) {
        Run run;
        run.outIsTerminal = true;
        server.jobs(run, json ? std::vector<std::string>{"list", "--json"}
                              : std::vector<std::string>{"list"});
        CHECK((run.out.str().find("CREATED") != std::string::npos) == !json);
        CHECK(lineCount(run.out.str()) == (json ? 5 : 6));
    }
}

TEST_CASE("jobs status: several, one of which is not there") {
    JobServer server;
    Run run;
    server.jobs(run, {"status", "job-3", "job-9x", "job-4"});
    CHECK(run.code == ExitCode::refused);
    CHECK(lineCount(run.out.str()) == 2);
    CHECK(run.err.str().find("job-9x") != std::string::npos);
}

TEST_CASE("jobs wait: ends as the jobs did") {
    const auto codeOf = [](const std::string& id) {
        JobServer server;
        Run run;
        return server.jobs(run, {"wait", id}).code;
    };
    CHECK(codeOf("job-1") == ExitCode::ok);
    CHECK(codeOf("job-3") == ExitCode::ok);
    CHECK(codeOf("job-4") == ExitCode::refused);
    CHECK(codeOf("job-5") == ExitCode::cancelled);
    JobServer server;
    Run run;
    server.jobs(run, {"wait", "job-2", "--timeout", "0.2"});
    CHECK(run.code == ExitCode::busy);
    CHECK(server.deleted.empty());
}

TEST_CASE("jobs cancel: only those that have not ended, as the others would be forgotten") {
    JobServer server;
    Run run;
    server.jobs(run, {"cancel", "job-1", "job-2", "job-3", "job-4", "--json"});
    CHECK(run.code == ExitCode::ok);
    CHECK(server.deleted == std::vector<std::string>{"job-1", "job-2"});
    std::istringstream lines(run.out.str());
    std::string line;
    std::getline(lines, line);
    CHECK(proto::Json::parse(line)["state"] == "canceled");
    CHECK(run.err.str() ==
          "job-3 had already ended: it succeeded, and its result stays\n"
          "job-4 had already ended: it failed\n");
}

TEST_CASE("jobs fetch: waits, and writes files, a folder or stdout") {
    JobServer server;
    Run run;
    server.jobs(run, {"fetch", "job-1", "-o", server.folder / "one.glb", "--json"});
    CHECK(run.code == ExitCode::ok);
    CHECK(contentOf(server.folder / "one.glb") == "result of job-1");
    CHECK(proto::Json::parse(run.out.str())["run"]["job"] == "job-1");

    Run two;
    server.jobs(two, {"fetch", "job-1", "job-3", "-o", server.folder / "new/"});
    CHECK(two.code == ExitCode::ok);
    CHECK(contentOf(server.folder / "new/job-3.obj") == "result of job-3");

    Run piped;
    server.jobs(piped, {"fetch", "job-3", "-o", "-"});
    CHECK(piped.out.str() == "result of job-3");

    Run failed;
    server.jobs(failed, {"fetch", "job-4", "-o", server.folder / "none.glb"});
    CHECK(failed.code == ExitCode::refused);
    CHECK_FALSE(std::filesystem::exists(server.folder / "none.glb"));
}

TEST_CASE("reject: jobs without a server, several results in one file, ids that are none") {
    JobServer server;
    Run none;
    CHECK(none({"jobs", "list"}).code == ExitCode::usage);
    CHECK(none.err.str().find("--server") != std::string::npos);
    Run one;
    CHECK(server.jobs(one, {"fetch", "job-1", "job-3", "-o", server.folder / "x.glb"}).code ==
          ExitCode::usage);
    Run bad;
    CHECK(server.jobs(bad, {"status", "../secrets"}).code == ExitCode::usage);
    Run missing;
    CHECK(server.jobs(missing, {"wait"}).code == ExitCode::usage);
}

TEST_SUITE_END();

}  // namespace rivage::client
