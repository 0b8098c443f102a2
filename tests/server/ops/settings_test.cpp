#include "server/ops/settings.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <vector>

using namespace rivage::server;
using namespace std::chrono_literals;

namespace {

/// What the command line prints and gives.
struct Outcome {
    CommandLine line;
    std::string out;
    std::string error;
};

Outcome run(std::vector<const char*> arguments) {
    arguments.insert(arguments.begin(), "rivage-server");
    std::ostringstream out;
    std::ostringstream error;
    std::streambuf* const oldOut = std::cout.rdbuf(out.rdbuf());
    std::streambuf* const oldError = std::cerr.rdbuf(error.rdbuf());
    CommandLine line = readCommandLine(static_cast<int>(arguments.size()), arguments.data());
    std::cout.rdbuf(oldOut);
    std::cerr.rdbuf(oldError);
    return {std::move(line), out.str(), error.str()};
}

struct Variable {
    const char* name;
    Variable(const char* variable, const char* value) : name(variable) {
        ::setenv(variable, value, 1);
    }
    ~Variable() { ::unsetenv(name); }
};

}  // namespace

TEST_SUITE_BEGIN("server/ops");

TEST_CASE("parseBytes and parseDuration: numbers with and without units") {
    CHECK(parseBytes("4096") == 4096);
    CHECK(parseBytes("64MiB") == 64ULL << 20);
    CHECK(parseBytes("1.5K") == 1536);
    CHECK(parseDuration("90") == 90s);
    CHECK(parseDuration("5m") == 300s);
    CHECK(parseDuration("1ms") == 1s);
    for (const char* text : {"", "x", "-1", "1 MB", "nan", "inf", "1e30", "MiB", "1Mb"}) {
        CAPTURE(text);
        CHECK_FALSE(parseBytes(text));
        CHECK_FALSE(parseDuration(text));
    }
}

TEST_CASE("settings: the defaults can be served") {
    const auto line = run({}).line;
    CHECK_FALSE(line.exitCode);
    const Settings& settings = line.settings;
    CHECK(settings.workers >= 1);
    CHECK(settings.memoryBudget > 0);
    CHECK(settings.pool().limits.maxMemory * settings.workers <= settings.memoryBudget);
    CHECK(settings.limits().maxUploadBytes == 64ULL << 20);
}

TEST_CASE("settings: every flag reaches its place") {
    const auto line =
        run({"--listen=[::1]:0", "--admin-listen=off", "--workers=3", "--threads-per-job=2",
             "--queue-limit=5", "--memory-budget=3GiB", "--result-budget=1M", "--max-upload=1K",
             "--max-voxels=7", "--max-labels=8", "--deadline=9s", "--result-ttl=1h",
             "--drain-timeout=0", "--connections=10", "--log-format=json", "--log-level=error"})
            .line;
    REQUIRE_FALSE(line.exitCode);
    const Settings& settings = line.settings;
    CHECK(settings.listen == "[::1]:0");
    CHECK(settings.adminListen == "off");
    CHECK(settings.logFormat == LogFormat::json);
    CHECK(settings.drainTimeout == 0s);
    CHECK(settings.connections == 10);
    const PoolSettings pool = settings.pool();
    CHECK(pool.workers == 3);
    CHECK(pool.threadsPerJob == 2);
    CHECK(pool.queueLimit == 5);
    CHECK(pool.limits.maxMemory == 1ULL << 30);
    CHECK(pool.limits.maxInputBytes == 1024);
    CHECK(pool.limits.maxVoxels == 7);
    CHECK(pool.limits.maxLabels == 8);
    CHECK(pool.deadline == 9s);
    CHECK(pool.store.resultTtl == 3600s);
    CHECK(pool.store.resultBytes == 1 << 20);
}

TEST_CASE("settings: environment and file, the flag wins over both") {
    const auto path = std::filesystem::temp_directory_path() / "rivage-settings-test.ini";
    std::ofstream(path) << "workers=4\nqueue-limit=6\ndeadline=\"7s\"\n";
    const std::string config = "--config=" + path.string();
    const Variable variable("RIVAGE_QUEUE_LIMIT", "9");
    const Settings settings = run({config.c_str(), "--workers=2"}).line.settings;
    CHECK(settings.workers == 2);
    CHECK(settings.queueLimit == 6);
    CHECK(settings.deadline == 7s);
    CHECK(run({}).line.settings.queueLimit == 9);
    std::ofstream(path) << "wrokers=4\n";
    CHECK(run({config.c_str()}).line.exitCode == 2);
    std::filesystem::remove(path);
}

TEST_CASE("settings: --print-config shows every setting, and reads back") {
    const Outcome printed = run({"--print-config", "--workers=3", "--deadline=5m"});
    CHECK(printed.line.exitCode == 0);
    for (const char* name :
         {"listen", "admin-listen", "workers", "threads-per-job", "queue-limit", "memory-budget",
          "result-budget", "max-upload", "max-voxels", "max-extent", "max-models", "max-labels",
          "deadline", "result-ttl", "drain-timeout", "connections", "log-format", "log-level"}) {
        CAPTURE(name);
        CHECK(("\n" + printed.out).find("\n" + std::string(name) + "=") != std::string::npos);
    }
    const auto path = std::filesystem::temp_directory_path() / "rivage-printed-test.ini";
    std::ofstream(path) << printed.out;
    const std::string config = "--config=" + path.string();
    const auto again = run({config.c_str()}).line;
    std::filesystem::remove(path);
    CHECK_FALSE(again.exitCode);
    CHECK(again.settings.workers == 3);
    CHECK(again.settings.deadline == 300s);
}

TEST_CASE("reject: unknown flags, and values that are none or out of range") {
    for (const char* bad :
         {"--wrokers=1", "--workers=0", "--workers=x", "--listen=nowhere", "--listen=a:99999",
          "--admin-listen=x", "--deadline=0", "--deadline=soon", "--max-upload=0",
          "--memory-budget=1K", "--log-format=xml", "--log-level=loud", "extra",
          "--max-labels=70000", "--config=/does/not/exist"}) {
        CAPTURE(bad);
        const Outcome outcome = run({bad});
        CHECK(outcome.line.exitCode == 2);
        CHECK_FALSE(outcome.error.empty());
    }
    const Variable variable("RIVAGE_WORKERS", "many");
    CHECK(run({}).line.exitCode == 2);
}

TEST_CASE("settings: --help and --version end well") {
    CHECK(run({"--help"}).line.exitCode == 0);
    const Outcome version = run({"--version"});
    CHECK(version.line.exitCode == 0);
    CHECK(version.out.starts_with("rivage-server "));
}

TEST_SUITE_END();
