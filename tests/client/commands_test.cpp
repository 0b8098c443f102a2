#include <doctest/doctest.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "tests/client/fake_server.h"
#include "tests/client/run.h"

namespace rivage::client {
namespace {

using namespace std::chrono_literals;

void answerProblem(httplib::Response& response, int status, const std::string& members) {
    response.status = status;
    response.set_content("{" + members + "}", "application/problem+json");
}

struct Fixture {
    TemporaryFolder folder;
    FakeServer server;
    FakeJobs jobs;
    std::string grid = folder / "house.vox";

    Fixture() { writeFile(grid, "VOX and more"); }
    void start() {
        jobs.addTo(server.http);
        server.start();
    }
    [[nodiscard]] std::vector<std::string> regularize(std::vector<std::string> more = {}) const {
        std::vector<std::string> all{"regularize", grid, "--server", server.url()};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
};

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("regularize: the result lands beside the input, the report on stderr") {
    Fixture fixture;
    fixture.start();
    Run run;
    run(fixture.regularize({"--alpha", "0.5", "--draco-speed", "7"}));
    CHECK(run.code == ExitCode::ok);
    CHECK(contentOf(fixture.folder / "house.glb") == fixture.jobs.result);
    CHECK(fixture.jobs.lastPost.body == "VOX and more");
    CHECK(fixture.jobs.lastPost.get_param_value("alpha") == "0.5");
    CHECK(fixture.jobs.lastPost.get_param_value("draco_speed") == "7");
    CHECK(fixture.jobs.lastPost.has_header("Idempotency-Key"));
    CHECK(run.err.str().find("house.glb") != std::string::npos);
    CHECK(run.err.str().find("model/gltf-binary") != std::string::npos);
    CHECK(run.out.str().empty());
}

TEST_CASE("regularize: the name of the result says its format") {
    Fixture fixture;
    fixture.start();
    Run run;
    run(fixture.regularize({"-o", fixture.folder / "other.obj"}));
    CHECK(run.code == ExitCode::ok);
    CHECK(fixture.jobs.lastPost.get_param_value("output") == "obj");
    Run any;
    any(fixture.regularize({"-o", fixture.folder / "house.v2", "--output", "glb"}));
    CHECK(any.code == ExitCode::ok);
    CHECK(contentOf(fixture.folder / "house.v2") == fixture.jobs.result);
}

TEST_CASE("regularize: to stdout where no temporary file can be made") {
    Fixture fixture;
    fixture.start();
    const char* const before = std::getenv("TMPDIR");
    const std::string kept = before ? before : "/tmp";
    for (const char* folder : {"/nonexistent", "/proc"}) {
        CAPTURE(folder);
        setenv("TMPDIR", folder, 1);
        Run run;
        run(fixture.regularize({"-o", "-"}));
        setenv("TMPDIR", kept.c_str(), 1);
        CHECK(run.code == ExitCode::ok);
        CHECK(run.out.str() == fixture.jobs.result);
    }
}

TEST_CASE("regularize: stdin to stdout") {
    Fixture fixture;
    fixture.jobs.result = std::string("\0\1glTF\n\xff", 8);
    fixture.start();
    Run run("grid from a pipe");
    run({"regularize", "-", "--server", fixture.server.url(), "--quiet"});
    CHECK(run.code == ExitCode::ok);
    CHECK(run.out.str() == fixture.jobs.result);
    CHECK(run.err.str().empty());
    CHECK(fixture.jobs.lastPost.body == "grid from a pipe");
}

TEST_CASE("regularize: --json prints the report on one line") {
    Fixture fixture;
    fixture.start();
    Run run;
    run(fixture.regularize({"--json"}));
    CHECK(run.code == ExitCode::ok);
    const auto line = proto::Json::parse(run.out.str());
    CHECK(line["output"]["media_type"] == "model/gltf-binary");
    CHECK(line["run"]["input"] == fixture.grid);
    CHECK(line["run"]["output"] == fixture.folder / "house.glb");
    CHECK(line["run"]["job"] == fixture.jobs.id);
}

TEST_CASE("regularize: a full server is asked again until it takes the job") {
    Fixture fixture;
    std::atomic<int> refusals{0};
    fixture.server.http.set_pre_routing_handler([&](const auto& request, auto& response) {
        if (request.method != "POST" || ++refusals > 2)
            return httplib::Server::HandlerResponse::Unhandled;
        answerProblem(response, 503, R"("title":"The server is full")");
        return httplib::Server::HandlerResponse::Handled;
    });
    fixture.start();
    Run run;
    run(fixture.regularize());
    CHECK(run.code == ExitCode::ok);
    CHECK(refusals == 3);
    CHECK(fixture.jobs.posts == 1);
}

TEST_CASE("reject: a server that stays full, within --timeout") {
    Fixture fixture;
    fixture.server.http.Post("/v1/jobs", [](const auto&, auto& response) {
        answerProblem(response, 503, R"("title":"The server is full","setting":"--queue-limit")");
    });
    fixture.start();
    Run run;
    run(fixture.regularize({"--timeout", "0.2"}));
    CHECK(run.code == ExitCode::busy);
    CHECK(run.err.str().find("--queue-limit") != std::string::npos);
}

TEST_CASE("reject: Retry-After beyond the deadline is not waited for") {
    Fixture fixture;
    fixture.server.http.Post("/v1/jobs", [](const auto&, auto& response) {
        answerProblem(response, 503, R"("title":"The server is full")");
        response.set_header("Retry-After", "3600");
    });
    fixture.start();
    const auto start = std::chrono::steady_clock::now();
    Run run;
    run(fixture.regularize());
    CHECK(run.code == ExitCode::busy);
    CHECK(std::chrono::steady_clock::now() - start < 5s);
}

TEST_CASE("reject: a problem is shown with its facts") {
    Fixture fixture;
    fixture.server.http.Post("/v1/jobs", [](const auto&, auto& response) {
        answerProblem(response, 413, R"("title":"The grid is too large","status":413,
            "detail":"9 voxels","field":"/grid","limit":8,"actual":9,"setting":"--max-voxels")");
    });
    fixture.start();
    Run run;
    run(fixture.regularize());
    CHECK(run.code == ExitCode::refused);
    for (const char* text : {"The grid is too large: 9 voxels", "field: /grid", "limit: 8",
                             "actual: 9", "setting: --max-voxels"})
        CHECK(run.err.str().find(text) != std::string::npos);
    CHECK(fixture.folder.entries() == 1);
}

TEST_CASE("reject: a job that fails ends as its problem says") {
    const auto codeOf = [](const std::string& status) {
        Fixture fixture;
        fixture.jobs.state = "failed";
        fixture.jobs.report = "null";
        fixture.jobs.error = R"({"title":"No","status":)" + status + "}";
        fixture.start();
        Run run;
        run(fixture.regularize());
        CHECK(fixture.folder.entries() == 1);
        return run.code;
    };
    CHECK(codeOf("422") == ExitCode::refused);
    CHECK(codeOf("500") == ExitCode::failed);
    CHECK(codeOf("504") == ExitCode::busy);
    CHECK(codeOf("409") == ExitCode::cancelled);
}

TEST_CASE("reject: a job that was cancelled at the server") {
    Fixture fixture;
    fixture.jobs.state = "canceled";
    fixture.start();
    Run run;
    run(fixture.regularize());
    CHECK(run.code == ExitCode::cancelled);
}

TEST_CASE("reject: a job that never ends stays at the server, and the words say how to fetch it") {
    Fixture fixture;
    fixture.jobs.state = "running";
    fixture.start();
    Run run;
    run(fixture.regularize({"--timeout", "0.3", "-o", fixture.folder / "a b.glb"}));
    CHECK(run.code == ExitCode::busy);
    CHECK(fixture.jobs.deletes == 0);
    CHECK(fixture.folder.entries() == 1);
    CHECK(run.err.str().find("rivage jobs fetch " + fixture.jobs.id + " -o '" +
                             (fixture.folder / "a b.glb") + "' --server " + fixture.server.url()) !=
          std::string::npos);
}

TEST_CASE("reject: a stop cancels the job at the server") {
    Fixture fixture;
    fixture.jobs.state = "running";
    fixture.start();
    Run run;
    std::thread person([&] {
        while (fixture.jobs.polls == 0) std::this_thread::sleep_for(1ms);
        run.interrupt.request();
    });
    run(fixture.regularize());
    person.join();
    CHECK(run.code == ExitCode::cancelled);
    CHECK(fixture.jobs.deletes == 1);
    CHECK(fixture.folder.entries() == 1);
}

TEST_CASE("reject: a result that breaks off leaves no file behind") {
    Fixture fixture;
    fixture.server.http.Get(
        "/v1/jobs/" + fixture.jobs.id + "/result", [](const auto&, auto& response) {
            response.set_content_provider(1000, "model/gltf-binary",
                                          [](std::size_t, std::size_t, httplib::DataSink& sink) {
                                              sink.write("only this", 9);
                                              return false;
                                          });
        });
    fixture.start();
    Run run;
    run(fixture.regularize());
    CHECK(run.code == ExitCode::unreachable);
    CHECK(fixture.folder.entries() == 1);
}

TEST_CASE("reject: nobody listens") {
    Fixture fixture;
    Run run;
    run({"regularize", fixture.grid, "--server", "http://127.0.0.1:1"});
    CHECK(run.code == ExitCode::unreachable);
    CHECK(run.err.str().find("http://127.0.0.1:1") != std::string::npos);
}

TEST_CASE("reject: an output that cannot be written") {
    Fixture fixture;
    fixture.start();
    Run run;
    run(fixture.regularize({"-o", fixture.folder / "no/such/folder.glb"}));
    CHECK(run.code == ExitCode::notWritten);
    CHECK(fixture.jobs.posts == 0);
}

TEST_CASE("reject: a wrong command line is refused before anything is sent") {
    Fixture fixture;
    fixture.start();
    const auto refused = [&](std::vector<std::string> arguments, const std::string& word) {
        CAPTURE(word);
        Run run;
        run(arguments);
        CHECK(run.code == ExitCode::usage);
        CHECK(run.err.str().find(word) != std::string::npos);
    };
    refused({}, "command");
    refused({"smooth"}, "smooth");
    refused(fixture.regularize({"--alpha", "0"}), "alpha");
    refused(fixture.regularize({"--preset", "best"}), "preset");
    refused(fixture.regularize({"--alfa", "1"}), "did you mean --alpha?");
    refused(fixture.regularize({"-o", "house.stl"}),
            "no result is a .stl, they are glb, obj, vox, nrrd");
    refused(fixture.regularize({"-o", "house.obj", "--output", "glb"}), "no name for --output glb");
    refused(fixture.regularize({fixture.folder / "missing.vox"}), "missing.vox");
    refused(fixture.regularize({"other.vox", "-o", "one.glb"}), "folder");
    refused({"regularize", "-", "--json", "--server", fixture.server.url()}, "--json");
    refused({"sample"}, "NAME");
    refused({"health", "--server", "ftp://x"}, "ftp://x");
    CHECK(fixture.jobs.posts == 1);  // house.vox, converted beside the missing one
}

TEST_CASE("regularize: one bad input does not keep the others from being converted") {
    Fixture fixture;
    fixture.start();
    writeFile(fixture.folder / "tree.vox", "VOX");
    Run run;
    run({"regularize", fixture.folder / "missing.vox", fixture.folder / "tree.vox", "-o",
         fixture.folder / "out/", "--server", fixture.server.url()});
    CHECK(run.code == ExitCode::usage);
    CHECK(contentOf(fixture.folder / "out/tree.glb") == fixture.jobs.result);
}

TEST_CASE("regularize: options too long for a request line go as a form") {
    Fixture fixture;
    fixture.start();
    std::string values;
    for (int i = 1; i < 250; ++i) values += (i > 1 ? "," : "") + std::to_string(i);
    std::string map = R"({"sea":[)" + values + "]";
    for (int i = 0; i < 200; ++i)
        map += R"(,"part)" + std::to_string(i) + R"(":[)" + std::to_string(1000 + i) + "]";
    Run run;
    run(fixture.regularize({"--format", "vox", "--alpha", "0.5", "--labels", map + "}"}));
    CHECK(run.code == ExitCode::ok);
    const auto& post = fixture.jobs.lastPost;
    REQUIRE(post.form.has_field("options"));
    const auto options = proto::Json::parse(post.form.get_field("options"));
    CHECK(options["alpha"] == 0.5);
    CHECK(options["labels"]["part7"] == proto::Json::array({1007}));
    CHECK(options.size() == 3);
    CHECK(post.form.get_file("grid").content == "VOX and more");
    CHECK(post.form.get_file("grid").filename == "house.vox");
}

TEST_CASE("regularize: the server is told the name of the file, in characters for headers") {
    Fixture fixture;
    fixture.start();
    const auto told = [&](const std::string& name) {
        const std::string path = fixture.folder / name;
        writeFile(path, "VOX");
        Run run;
        run({"regularize", path, "--server", fixture.server.url()});
        CHECK(run.code == ExitCode::ok);
        return fixture.jobs.lastPost.get_header_value("Content-Disposition");
    };
    CHECK(told("house.vox") == "attachment; filename=\"house.vox\"");
    CHECK(told("Dörf 1-b.vox") == "attachment; filename=\"D_rf_1-b.vox\"");
    CHECK(told("a\"\r\nX: y.vox") == "attachment; filename=\"a___X__y.vox\"");
}

TEST_CASE("sample, options, health: what the server says") {
    Fixture fixture;
    fixture.server.http.Get("/v1/samples/torus", [](const auto&, auto& response) {
        response.set_content("VOX torus", "application/octet-stream");
    });
    fixture.server.http.Get("/v1/samples", [](const auto&, auto& response) {
        response.set_content(R"({"samples":[{"name":"torus"}]})", "application/json");
    });
    fixture.server.http.Get("/version", [](const auto&, auto& response) {
        response.set_content(R"({"name":"rivage","version":"9"})", "application/json");
    });
    fixture.server.http.Get("/v1/options", [](const auto&, auto& response) {
        response.set_content(proto::writeJson(proto::describeOptions()), "application/json");
    });
    fixture.start();
    const std::string out = fixture.folder / "t.vox";
    CHECK(Run()({"sample", "torus", "-o", out, "--server", fixture.server.url()}).code ==
          ExitCode::ok);
    CHECK(contentOf(out) == "VOX torus");
    CHECK(Run()({"sample", "--list", "--server", fixture.server.url()}).out.str() == "torus\n");
    CHECK(Run()({"health", "--server", fixture.server.url()}).out.str() == "rivage 9 answers\n");
    const std::string options = Run()({"options", "--server", fixture.server.url()}).out.str();
    CHECK(options.find("--displacement-limit") != std::string::npos);
    CHECK(Run()({"sample", "cube", "-o", "-", "--server", fixture.server.url()}).code ==
          ExitCode::refused);
}

TEST_CASE("help and version end well") {
    Run help;
    CHECK(help({"regularize", "--help"}).code == ExitCode::ok);
    for (const proto::OptionInfo& info : proto::optionInfos()) {
        std::string flag = "--" + info.name;
        std::replace(flag.begin(), flag.end(), '_', '-');
        CHECK_MESSAGE(help.out.str().find(flag) != std::string::npos, flag);
    }
    CHECK(Run()({"--version"}).out.str().starts_with("rivage "));
}

TEST_SUITE_END();

}  // namespace rivage::client
