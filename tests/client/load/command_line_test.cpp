#include "client/load/command_line.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "../fake_server.h"
#include "client/load/stub_server.h"

namespace rivage::client::load {
namespace {

/// What a command line came to.
struct Ended {
    int code;
    std::string out;
    std::string err;
};

Ended command(const std::vector<std::string>& arguments) {
    std::istringstream in;
    std::ostringstream out;
    std::ostringstream err;
    Console console{in, out, err};
    const auto options = parseLoadCommandLine(arguments, console);
    Interrupt interrupt;
    const LoadExit exit = options ? runLoadCommand(*options, console, interrupt) : options.error();
    return {static_cast<int>(exit), out.str(), err.str()};
}

std::vector<std::string> runAt(const std::string& url, std::vector<std::string> more) {
    std::vector<std::string> arguments{"run",        "--server", url,        "--get", "/",
                                       "--duration", "0.5",      "--warmup", "0"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
}

TEST_SUITE("client/load") {
    TEST_CASE("command line: help with examples, and the version") {
        const Ended help = command({"--help"});
        CHECK(help.code == 0);
        CHECK(help.out.find("rivage-load search") != std::string::npos);
        CHECK(help.out.find("Exit codes") != std::string::npos);
        CHECK(command({"--version"}).out.starts_with("rivage-load "));
    }

    TEST_CASE("command line: the man page and the completions know every command") {
        const std::string man = command({"man"}).out;
        for (const char* text : {".TH", "search", "max\\-errors", "RIVAGE_API_KEY", "EXIT STATUS"})
            CHECK(man.find(text) != std::string::npos);
        for (const char* shell : {"bash", "zsh", "fish"}) {
            const Ended completions = command({"completions", shell});
            CHECK(completions.code == 0);
            CHECK(completions.out.find("concurrency") != std::string::npos);
        }
        CHECK(command({"completions", "csh"}).code == 2);
    }

    TEST_CASE("reject: command lines that make no sense") {
        unsetenv("RIVAGE_SERVER");
        const std::string url = "http://127.0.0.1:1";
        for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
                 {},
                 {"go"},
                 {"run", "--rate", "1"},
                 {"run", "--server", url},
                 {"run", "--server", url, "--rate", "1", "--concurrency", "1"},
                 {"run", "--server", url, "--concurrency", "1", "--poisson"},
                 {"run", "--server", url, "--rate", "-1"},
                 {"run", "--server", url, "--rate", "1", "--duration", "7200"},
                 {"run", "--server", url, "--rate", "1", "--mix", "a", "--get", "/"},
                 {"run", "--server", url, "--rate", "1", "--mix", "/nonexistent"},
                 {"run", "--server", url, "--rate", "1", "--slo", "fast"},
                 {"run", "--server", url, "--rate", "1", "--get", "/a b"},
                 {"run", "--server", url, "--rate", "1", "--get", "/\r\nX: y"},
                 {"run", "--server", url, "--rate", "1", "--admin", "http://192.0.2.1"},
                 {"run", "--server", url, "--replay", "/nonexistent"},
                 {"run", "--server", "ftp://x", "--rate", "1"},
                 {"run", "--server", url, "--rate", "1", "--api-key-file", "/nonexistent"},
                 {"search", "--server", url, "--rate", "1"}}) {
            CAPTURE(arguments);
            const Ended ended = command(arguments);
            CHECK(ended.code == 2);
            CHECK(ended.err.starts_with("rivage-load: "));
        }
    }

    TEST_CASE("reject: numbers that are none, by the name of the option") {
        const std::string url = "http://127.0.0.1:1";
        for (const char* option : {"--rate", "--timeout", "--verify", "--duration", "--warmup"})
            for (const char* value : {"nan", "inf", "-inf", "1e999"}) {
                CAPTURE(option);
                CAPTURE(value);
                std::vector<std::string> arguments{"run", "--server", url, option, value};
                if (option != std::string("--rate"))
                    arguments.insert(arguments.end(), {"--rate", "1"});
                const Ended ended = command(arguments);
                CHECK(ended.code == 2);
                CHECK(ended.err.find(option) != std::string::npos);
            }
        for (const char* option : {"--from", "--precision", "--window", "--max-errors", "--curve"})
            CHECK(command({"search", "--server", url, option, "nan"}).code == 2);
        CHECK(command({"run", "--server", url, "--rate", "1", "--seed", "-1"}).code == 2);
        CHECK(command({"run", "--server", url, "--rate", "1", "--max-requests", "0"}).code == 2);
        const Ended slo = command({"run", "--server", url, "--rate", "1", "--slo", "p99=0.4us"});
        CHECK(slo.code == 2);
        CHECK(slo.err.find("1us") != std::string::npos);
    }

    TEST_CASE("reject: a slip is told, and what it was perhaps") {
        CHECK(command({"run", "--rat", "5"}).err.find("did you mean --rate?") != std::string::npos);
        CHECK(command({"search", "--slow=p99=1s"}).err.find("did you mean --slo?") !=
              std::string::npos);
        CHECK(command({"go"}).err.find("there is no command \"go\"; there are run, search") !=
              std::string::npos);
        const Ended steering = command({"stub", "--p\x1b[2Jat"});
        CHECK(steering.err.find("--p?[2Jat") != std::string::npos);
        CHECK(steering.err.find('\x1b') == std::string::npos);
    }

    TEST_CASE("safety: another machine is only asked if its owner says so") {
        const Ended ended = command({"run", "--server", "http://192.0.2.1", "--rate", "1"});
        CHECK(ended.code == 2);
        CHECK(ended.err.find("--i-own-this") != std::string::npos);
        for (const char* url : {"http://127.0.0.1:1", "http://127.9.9.9:1", "http://[::1]:1",
                                "http://localhost:1", "unix:/nonexistent"}) {
            CAPTURE(url);
            CHECK(resolveTarget(*parseEndpoint(url))->local);
        }
        CHECK_FALSE(resolveTarget(*parseEndpoint("http://192.0.2.1"))->local);
    }

    TEST_CASE("exit codes: 0 kept, 1 missed, 4 nobody there") {
        const StubServer stub({});
        CHECK(command(runAt(stub.url(), {"--concurrency", "2", "--slo", "p50=1s"})).code == 0);
        CHECK(command(runAt(stub.url(), {"--concurrency", "2", "--slo", "p50=1us"})).code == 1);
        CHECK(command(runAt("http://127.0.0.1:1", {"--rate", "10"})).code == 4);
        const Ended missed =
            command(runAt(stub.url(), {"--concurrency", "2", "--slo", "p50=1us", "--json"}));
        CHECK(missed.code == 1);
        CHECK(missed.err.starts_with("rivage-load: MISSED   p50 = "));
    }

    TEST_CASE("run: a folder with the report in all its forms") {
        const StubServer stub({});
        const TemporaryFolder folder;
        const std::string out = folder / "new/report";
        const Ended ended = command(runAt(stub.url(), {"--concurrency", "2", "--out", out}));
        CHECK(ended.code == 0);
        for (const char* name : {"report.json", "report.md", "seconds.csv", "corrected.hgrm",
                                 "as_sent.hgrm", "latency.svg"}) {
            CAPTURE(name);
            CHECK(std::filesystem::file_size(out + "/" + name) > 100);
        }
        const Ended json = command(runAt(stub.url(), {"--concurrency", "2", "--json"}));
        CHECK(proto::Json::parse(json.out)["exit_code"] == 0);
        // Before the run: nobody has to be there.
        const std::string nobody = "http://127.0.0.1:1";
        CHECK(command(runAt(nobody, {"--concurrency", "1", "--out", "/proc/x"})).code == 8);
        const std::string odd = folder / "\xff";
        CHECK(command(runAt(stub.url(), {"--concurrency", "1", "--out", odd})).code == 0);
        CHECK(std::filesystem::file_size(odd + "/report.json") > 100);
    }

    TEST_CASE("run: the key goes along, and is never shown") {
        FakeServer server;
        std::atomic<int> right{0};
        std::atomic<int> wrong{0};
        server.http.Get("/", [&](const auto& request, auto&) {
            ++(request.get_header_value("Authorization") == "Bearer secret-1" ? right : wrong);
        });
        server.start();
        const TemporaryFolder folder;
        std::ofstream(folder / "key") << "secret-1\n";
        const Ended ended = command(runAt(
            server.url(), {"--concurrency", "1", "--json", "--api-key-file", folder / "key"}));
        CHECK(right > 0);
        CHECK(wrong == 0);
        CHECK((ended.out + ended.err).find("secret-1") == std::string::npos);
    }

    TEST_CASE("output: what stdout does not take ends with 8") {
        const StubServer stub({});
        std::istringstream in;
        for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
                 {"--help"},
                 {"run", "--help"},
                 {"--version"},
                 {"man"},
                 {"completions", "bash"},
                 {"stub"},
                 runAt(stub.url(), {"--concurrency", "1"}),
                 runAt(stub.url(), {"--concurrency", "1", "--json", "--slo", "p50=1us"})}) {
            CAPTURE(arguments);
            std::ofstream full("/dev/full");
            std::ostringstream err;
            Console console{in, full, err};
            const auto options = parseLoadCommandLine(arguments, console);
            Interrupt interrupt;
            const LoadExit exit =
                options ? runLoadCommand(*options, console, interrupt) : options.error();
            CHECK(exit == LoadExit::notWritten);
            CHECK(err.str().find("rivage-load: stdout cannot be written\n") != std::string::npos);
        }
    }

    TEST_CASE("search: nobody there") {
        CHECK(command({"search", "--server", "http://127.0.0.1:1", "--get", "/"}).code == 4);
    }
}

}  // namespace
}  // namespace rivage::client::load
