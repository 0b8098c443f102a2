#include "client/settings.h"

#include <doctest/doctest.h>

#include "tests/client/fake_server.h"
#include "tests/client/run.h"

namespace rivage::client {
namespace {

/// A variable of the environment for one test.
class Variable {
public:
    Variable(const char* name, const std::string& value) : name_(name) {
        setenv(name, value.c_str(), 1);
    }
    ~Variable() { unsetenv(name_); }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

private:
    const char* name_;
};

struct Read {
    std::istringstream in;
    std::ostringstream out;
    std::ostringstream err;
    CommandLine result;

    explicit Read(const std::vector<std::string>& arguments)
        : result(tl::unexpected(ExitCode::usage)) {
        setenv("RIVAGE_CONFIG", "/dev/null", 0);
        Console console{in, out, err};
        result = parseCommandLine(arguments, console);
    }
    [[nodiscard]] std::string option(const std::string& name) const {
        REQUIRE(result);
        for (const proto::OptionText& option : result->options)
            if (option.name == name) return option.value;
        return {};
    }
};

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("settings: lines, comments, quotes") {
    std::istringstream text(
        "# mine\n\n preset =  paper \nlabels = {\"sea\":[1,2]}\nserver='unix:/a b'\r\n"
        "draco_speed = 3");
    const auto settings = readSettings(text, "f");
    REQUIRE(settings);
    REQUIRE(settings->size() == 4);
    CHECK((*settings)[0].name == "preset");
    CHECK((*settings)[0].value == "paper");
    CHECK((*settings)[1].value == R"({"sea":[1,2]})");
    CHECK((*settings)[2].value == "unix:/a b");
    CHECK((*settings)[3].name == "draco-speed");
    CHECK((*settings)[3].place == "f:6");
}

TEST_CASE("settings: a byte order mark before the first line") {
    std::istringstream text("\xef\xbb\xbfpreset = paper\n");
    const auto settings = readSettings(text, "f");
    REQUIRE(settings);
    REQUIRE(settings->size() == 1);
    CHECK((*settings)[0].name == "preset");
}

TEST_CASE("reject: a time that is no number, from the command line and the file") {
    const TemporaryFolder folder;
    for (const std::string text : {"nan", "inf", "-nan", "-inf"}) {
        CAPTURE(text);
        CHECK(Read({"health", "--timeout", text}).result.error() == ExitCode::usage);
        writeFile(folder / "config", "timeout = " + text + "\n");
        CHECK(Read({"health", "--config", folder / "config"}).result.error() == ExitCode::usage);
        CHECK(Read({"compare", "a", "b", "--max-distance", text}).result.error() ==
              ExitCode::usage);
    }
}

TEST_CASE("settings: command line over environment over file") {
    const TemporaryFolder folder;
    const std::string file = folder / "config";
    writeFile(file, "preset = architectural\nworkers = 3\ntimeout = 5\njson = true\n");
    const Read fromFile({"regularize", "a.vox", "--config", file});
    CHECK(fromFile.option("preset") == "architectural");
    CHECK(fromFile.result->workers == 3);
    CHECK(fromFile.result->timeout == std::chrono::seconds(5));
    CHECK(fromFile.result->json);
    const Variable preset("RIVAGE_CLIENT_PRESET", "paper");
    const Variable workers("RIVAGE_CLIENT_WORKERS", "4");
    const Variable config("RIVAGE_CONFIG", file);
    const Read fromVariable({"regularize", "a.vox"});
    CHECK(fromVariable.option("preset") == "paper");
    CHECK(fromVariable.result->workers == 4);
    CHECK(fromVariable.result->timeout == std::chrono::seconds(5));
    const Read given({"regularize", "a.vox", "--preset", "organic", "-w", "5"});
    CHECK(given.option("preset") == "organic");
    CHECK(given.result->workers == 5);
}

TEST_CASE("settings: the method does not matter to a command that converts nothing") {
    const TemporaryFolder folder;
    const std::string file = folder / "config";
    writeFile(file, "preset = paper\nhidden = keep\n");
    const Read inspect({"inspect", "a.vox", "--config", file});
    CHECK(inspect.option("preset").empty());
    CHECK(inspect.option("hidden") == "keep");
    CHECK(Read({"health", "--config", file}).result->options.empty());
}

TEST_CASE("reject: settings that are none, with file and line") {
    const TemporaryFolder folder;
    const std::string file = folder / "config";
    const auto refused = [&](const std::string& text, const std::string& word) {
        writeFile(file, text);
        const Read read({"regularize", "a.vox", "--config", file});
        CAPTURE(read.err.str());
        REQUIRE_FALSE(read.result);
        CHECK(read.result.error() == ExitCode::usage);
        CHECK(read.err.str().find(word) != std::string::npos);
        CHECK(read.err.str().find(file) != std::string::npos);
    };
    refused("\npresett = paper\n", ":2: there is no setting \"presett\"; did you mean preset?");
    refused("preset\n", ":1: expected name = value");
    refused("preset = best\n", "preset must be");
    refused("timeout = soon\n", ":1: --timeout");
    refused("json = maybe\n", ":1: ");
    refused("preset = paper\npreset = paper\n", ":2: preset is set twice");
    refused("out = x\n", "there is no setting");
    refused("watch = true\n", "there is no setting");
    const Read missing({"health", "--config", folder / "none"});
    CHECK_FALSE(missing.result);
    CHECK(missing.err.str().find(folder / "none") != std::string::npos);
}

TEST_CASE(
    "reject: variables of the client that are none; those of the server are not its business") {
    {
        const Variable server("RIVAGE_WORKERS", "many");
        CHECK(Read({"health"}).result);
    }
    const Variable wrong("RIVAGE_CLIENT_WORKER", "1");
    const Read read({"health"});
    CHECK_FALSE(read.result);
    CHECK(read.err.str().find("RIVAGE_CLIENT_WORKER") != std::string::npos);
}

TEST_CASE("settings: the API key comes from a file or the environment and is never shown") {
    const TemporaryFolder folder;
    writeFile(folder / "key", "s3cret\n");
    writeFile(folder / "bad", "two words\n");
    CHECK(Read({"health", "--api-key-file", folder / "key"}).result->apiKey == "s3cret");
    const Read bad({"health", "--api-key-file", folder / "bad"});
    CHECK_FALSE(bad.result);
    CHECK(bad.err.str().find("two words") == std::string::npos);
    CHECK_FALSE(Read({"health", "--api-key-file", folder / "none"}).result);
    const Variable key("RIVAGE_API_KEY", "fr0m-environment");
    CHECK(Read({"health"}).result->apiKey == "fr0m-environment");
    CHECK(Read({"health", "--api-key-file", folder / "key"}).result->apiKey == "s3cret");

    FakeServer server;
    std::string authorization;
    server.http.Get("/version", [&](const httplib::Request& request, auto& response) {
        authorization = request.get_header_value("Authorization");
        response.set_content(R"({"name":"rivage","version":"1"})", "application/json");
    });
    server.start();
    Run run;
    run({"health", "--server", server.url()});
    CHECK(run.code == ExitCode::ok);
    CHECK(authorization == "Bearer fr0m-environment");
}

TEST_SUITE_END();

}  // namespace rivage::client
