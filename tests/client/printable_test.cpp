#include "client/printable.h"

#include <doctest/doctest.h>

#include <sstream>

#include "client/progress.h"
#include "client/report_table.h"
#include "tests/client/fake_server.h"
#include "tests/client/run.h"

namespace rivage::client {
namespace {

/// What nothing from outside may bring to a terminal: ESC, BEL, BS, DEL, CSI of C1, a mark that
/// turns the direction, and a byte that is no UTF-8.
const std::vector<std::string> kSteering{"\x1b",     "\x07",         "\x08",         "\x7f",
                                         "\xc2\x9b", "\xe2\x80\xae", "\xe2\x81\xa6", "\xff"};

const std::string kHostile =
    "x\x1b[2J\x07\x08\x7f\xc2\x9b"
    "31m\xe2\x80\xae\xe2\x81\xa6y\xff\nrivage: forged";

/// The same in JSON, which cannot hold the byte that is no UTF-8.
const std::string kHostileJson =
    R"("x\u001b[2J\u0007\b\u007f\u009b31m\u202e\u2066y\nrivage: forged")";

void checkSafe(const std::string& text) {
    CAPTURE(text);
    for (const std::string& bytes : kSteering) CHECK(text.find(bytes) == std::string::npos);
    CHECK(text.find('\r') == std::string::npos);
    CHECK_FALSE(text.starts_with("rivage: forged"));
    CHECK(text.find("\nrivage: forged") == std::string::npos);
}

/// A server all of whose words are hostile.
struct HostileServer {
    FakeServer server;

    HostileServer() {
        answer("/v1/jobs", R"({"jobs":[{"id":H,"state":H,"stage":H,"created":H,"progress":0.5,)"
                           R"("error":{"title":H}}]})");
        answer("/v1/jobs/a", R"({"id":H,"state":"failed","stage":H,"error":{"title":H,"detail":H,)"
                             R"("field":H,"limit":[H]}})");
        answer("/v1/samples", R"({"samples":[H,{"name":H,"description":H}]})");
        answer("/v1/options", R"({"options":[{"name":H,"group":H,"values":[H],"default":H,)"
                              R"("description":H,"type":H}]})");
        answer("/version", R"({"name":H,"version":H})");
        answer("/v1/samples/s", R"({"title":H,"detail":H,"field":H})", 404);
        server.http.Post("/v1/inspect", [](const httplib::Request&, httplib::Response& response) {
            response.set_content(filled(R"({"input":{"format":H,"labels":[{"name":H}]},)"
                                        R"("palette":[{"name":H,"color":H,"class":H,"label":H}],)"
                                        R"("warnings":[H]})"),
                                 "application/json");
        });
        server.start();
    }

private:
    static std::string filled(const std::string& pattern) {
        std::string text;
        for (const char c : pattern) text += c == 'H' ? kHostileJson : std::string(1, c);
        return text;
    }
    void answer(const std::string& path, const std::string& pattern, int status = 200) {
        server.http.Get(path, [pattern, status](const httplib::Request&, httplib::Response& to) {
            to.status = status;
            to.set_content(filled(pattern), "application/json");
        });
    }
};

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("printable: text stays, what steers a terminal does not") {
    CHECK(printable("plain, \xc3\xa4\xe6\x97\xa5\xf0\x9f\x98\x80") ==
          "plain, \xc3\xa4\xe6\x97\xa5\xf0\x9f\x98\x80");
    CHECK(printable("a\tb\r\nc\x1b[2Jd\x7f") == "a?b??c?[2Jd?");
    CHECK(printable("\xc2\x80\xc2\x9b\xc2\x9f\xc2\xa0") == "???\xc2\xa0");
    CHECK(printable("\xe2\x80\xaa\xe2\x80\xae\xe2\x81\xa6\xe2\x81\xa9\xe2\x80\x8e\xd8\x9c"
                    "\xe2\x80\xa8") == "???????");
    CHECK(printable(std::string("\0z", 2)) == "?z");
}

TEST_CASE("printable: what is no UTF-8") {
    // Overlong, a surrogate, beyond the last character, cut off, a byte that begins nothing; an
    // overlong ESC too, which a lax terminal would take for one.
    CHECK(printable("\xc0\x9b") == "??");
    CHECK(printable("\xe0\x82\x9b") == "???");
    CHECK(printable("\xed\xa0\x80") == "???");
    CHECK(printable("\xf4\x90\x80\x80") == "????");
    CHECK(printable("\xf0\x80\x80\x80") == "????");
    CHECK(printable("a\xe6\x97") == "a??");
    CHECK(printable("\x9b\xff") == "??");
}

TEST_CASE("printable: a text is not cut inside of a character") {
    CHECK(cutTo("ab\xc3\xa4", 4) == "ab\xc3\xa4");
    CHECK(cutTo("ab\xc3\xa4", 3) == "ab");
    CHECK(cutTo("ab", 0).empty());
}

TEST_CASE("printable: JSON stays the same document") {
    const proto::Json json{{"name", "\x1b\x7f\xc2\x9b\xe2\x80\xae\xc3\xa4"}};
    const std::string line = jsonLine(json);
    checkSafe(line);
    CHECK(line == "{\"name\":\"\\u001b\\u007f\\u009b\\u202e\xc3\xa4\"}\n");
    CHECK(proto::Json::parse(line) == json);
}

TEST_CASE("printable: no word of a server steers the terminal") {
    HostileServer server;
    TemporaryFolder folder;
    writeFile(folder / "g.vox", "VOX");
    const std::vector<std::vector<std::string>> commands{{"jobs", "list"},
                                                         {"jobs", "status", "a"},
                                                         {"jobs", "wait", "a"},
                                                         {"jobs", "cancel", "a"},
                                                         {"options"},
                                                         {"health"},
                                                         {"sample", "--list"},
                                                         {"sample", "s"},
                                                         {"inspect", folder / "g.vox"}};
    for (const bool json : {false, true})
        for (auto command : commands) {
            CAPTURE(command.back());
            command.insert(command.end(), {"--server", server.server.url()});
            if (json) command.emplace_back("--json");
            Run run;
            run(command);
            CHECK(run.out.str().size() + run.err.str().size() > 0);
            checkSafe(run.out.str());
            checkSafe(run.err.str());
        }
}

TEST_CASE("printable: nor does a report, or the name of a file") {
    TemporaryFolder folder;
    FakeServer server;
    FakeJobs jobs;
    jobs.report = R"({"input":{"format":H,"labels":[{"name":H}]},"solver":{"name":H},)"
                  R"("output":{"media_type":H},"milliseconds":{H:1},"warnings":[H]})";
    std::string text;
    for (const char c : jobs.report) text += c == 'H' ? kHostileJson : std::string(1, c);
    jobs.report = text;
    jobs.addTo(server.http);
    server.start();
    const std::string grid = folder / (kHostile + ".vox");
    writeFile(grid, "VOX");
    for (const bool json : {false, true}) {
        std::vector<std::string> words{"regularize", grid, "--server", server.url()};
        if (json) words.emplace_back("--json");
        Run run;
        run(words);
        CHECK(run.code == ExitCode::ok);
        checkSafe(run.out.str());
        checkSafe(run.err.str());
        CHECK(proto::Json::accept(json ? run.out.str() : "{}"));
        Run again;
        again({"regularize", grid, "--if-newer", "--preset", kHostile, "--server", server.url()});
        checkSafe(again.err.str());
        Run missing;
        missing({"regularize", folder / kHostile, "--server", server.url(), kHostile});
        CHECK(missing.code == ExitCode::usage);
        checkSafe(missing.err.str());
    }
}

TEST_CASE("printable: a bar shows no name and no stage that steers the terminal") {
    std::istringstream in;
    std::ostringstream out;
    std::ostringstream err;
    Console console{in, out, err, false, true, 60, 10};
    ProgressBoard board(console, false, 1);
    const std::size_t line = board.begin(kHostile);
    board.update(line, {.state = "running", .stage = kHostile, .fraction = 1e308});
    std::string text = err.str();
    // What the board itself writes.
    for (const std::string own : {"\r\x1b[J"})
        for (std::size_t at = text.find(own); at != std::string::npos; at = text.find(own))
            text.erase(at, own.size());
    checkSafe(text);
}

TEST_SUITE_END();

}  // namespace rivage::client
