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
    CHECK(settings.pool().store.resultTtl == 24h);
    CHECK(settings.pool().store.jobs == 1000);
    CHECK(settings.connections == 1024);
    CHECK(settings.uploadBytes() >= 2 * settings.maxUpload);
}

TEST_CASE("settings: the upload budget follows the other limits, unless it is set") {
    Settings settings;
    settings.workers = 2;
    settings.queueLimit = 2;
    settings.maxUpload = 100;
    settings.memoryBudget = 1 << 20;
    CHECK(settings.uploadBytes() == 400);
    settings.memoryBudget = 8 * 300;
    CHECK(settings.uploadBytes() == 300);
    settings.memoryBudget = 8;
    CHECK(settings.uploadBytes() == 200);
    settings.maxUpload = 1ULL << 60;
    CHECK(settings.uploadBytes() == 1ULL << 61);
    settings.uploadBudget = 5;
    CHECK(settings.uploadBytes() == 5);
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

TEST_CASE("settings: the flags of connections, access and durable jobs reach their places") {
    const auto line =
        run({"--cors-origin=https://a.example", "--cors-origin", "http://b:8443,https://c",
             "--trusted-proxy=10.0.0.1,::1", "--streams=1", "--long-polls=2", "--header-timeout=3s",
             "--body-timeout=4m", "--min-body-rate=5KiB", "--write-timeout=6", "--idle-timeout=7s",
             "--upload-budget=1GiB", "--state-dir=/tmp/x", "--kept-jobs=8", "--drain-delay=9s",
             "--supervise=false", "--watchdog=10s", "--quarantine-ttl=11d"})
            .line;
    REQUIRE_FALSE(line.exitCode);
    const Settings& settings = line.settings;
    CHECK(settings.corsOrigins ==
          std::vector<std::string>{"https://a.example", "http://b:8443", "https://c"});
    CHECK(settings.trustedProxies == std::vector<std::string>{"10.0.0.1", "::1"});
    CHECK(settings.headerTimeout == 3s);
    CHECK(settings.writeTimeout == 6s);
    CHECK(settings.stateDir == "/tmp/x");
    CHECK(settings.drainDelay == 9s);
    CHECK_FALSE(settings.supervise);
    CHECK(settings.watchdog == 10s);
    CHECK(settings.quarantineTtl == 11 * 24h);
    CHECK(settings.pool().store.jobs == 8);
    const auto limits = settings.limits();
    CHECK(limits.uploadBudget == 1ULL << 30);
    CHECK(limits.streams == 1);
    CHECK(limits.longPolls == 2);
    CHECK(limits.bodyTimeout == 240s);
    CHECK(limits.minBodyRate == 5120);
    CHECK(limits.idleTimeout == 7s);
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
    const Outcome printed = run({"--print-config", "--workers=3", "--deadline=5m",
                                 "--supervise=false", "--cors-origin=https://a,https://b"});
    CHECK(printed.line.exitCode == 0);
    for (const char* name :
         {"listen",         "admin-listen",  "workers",       "threads-per-job", "queue-limit",
          "memory-budget",  "result-budget", "max-upload",    "max-voxels",      "max-extent",
          "max-models",     "max-labels",    "deadline",      "result-ttl",      "drain-timeout",
          "connections",    "log-format",    "log-level",     "api-keys",        "tls-cert",
          "tls-key",        "cors-origin",   "trusted-proxy", "streams",         "long-polls",
          "header-timeout", "body-timeout",  "min-body-rate", "write-timeout",   "idle-timeout",
          "upload-budget",  "state-dir",     "kept-jobs",     "drain-delay",     "supervise",
          "watchdog",       "quarantine-ttl"}) {
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
    CHECK_FALSE(again.settings.supervise);
    CHECK(again.settings.corsOrigins == std::vector<std::string>{"https://a", "https://b"});
}

TEST_CASE("settings: the help shows no variable that Kubernetes sets for a service") {
    const std::string help = run({"--help"}).out;
    CHECK(help.find("RIVAGE_KEPT_JOBS") != std::string::npos);
    CHECK(help.find("_PORT)") == std::string::npos);
}

TEST_CASE("reject: unknown flags, and values that are none or out of range") {
    for (const char* bad : {"--wrokers=1",
                            "--workers=0",
                            "--workers=x",
                            "--listen=nowhere",
                            "--listen=a:99999",
                            "--admin-listen=x",
                            "--deadline=0",
                            "--deadline=soon",
                            "--max-upload=0",
                            "--memory-budget=1K",
                            "--log-format=xml",
                            "--log-level=loud",
                            "extra",
                            "--max-labels=70000",
                            "--config=/does/not/exist",
                            "--cors-origin=*",
                            "--cors-origin=null",
                            "--cors-origin=https://a/",
                            "--cors-origin=https://A",
                            "--cors-origin=https://",
                            "--trusted-proxy=host",
                            "--streams=-1",
                            "--supervise=maybe",
                            "--min-body-rate=0",
                            "--header-timeout=0",
                            "--kept-jobs=0",
                            "--upload-budget=1K"}) {
        CAPTURE(bad);
        const Outcome outcome = run({bad});
        CHECK(outcome.line.exitCode == 2);
        CHECK_FALSE(outcome.error.empty());
    }
    const Variable variable("RIVAGE_WORKERS", "many");
    CHECK(run({}).line.exitCode == 2);
}

TEST_CASE("reject: settings that do not go together, by a message that names the flag") {
    const auto path = std::filesystem::temp_directory_path() / "rivage-settings-file";
    std::ofstream(path) << "x";
    const std::string cert = "--tls-cert=" + path.string();
    const std::string below = "--state-dir=" + path.string() + "/state";
    CHECK(run({cert.c_str()}).error.find("--tls-cert needs --tls-key") != std::string::npos);
    CHECK(run({"--tls-key=/none"}).error.find("--tls-key needs --tls-cert") != std::string::npos);
    CHECK(run({cert.c_str(), "--tls-key=/none"}).error.find("--tls-key: cannot read /none") !=
          std::string::npos);
    CHECK(run({below.c_str()}).error.starts_with("--state-dir: "));
    CHECK(run({below.c_str()}).line.exitCode == 2);
    std::filesystem::remove(path);
}

TEST_CASE("reject: a RIVAGE_ variable that is no setting, unless it belongs to somebody else") {
    {
        const Variable slip("RIVAGE_WORKRS", "3");
        const Outcome outcome = run({});
        CHECK(outcome.line.exitCode == 2);
        CHECK(outcome.error.find("did you mean RIVAGE_WORKERS?") != std::string::npos);
    }
    const std::vector<std::string> known{"RIVAGE_WORKERS"};
    CHECK(unknownVariable({"PATH", "RIVAGE_WORKERS", "RIVAGE_SERVER", "RIVAGE_CACHE",
                           "RIVAGE_REFERENCE", "RIVAGE_HTTPLIB_DIR", "RIVAGE_API_KEY",
                           "RIVAGE_CA_FILE", "RIVAGE_API_KEY_FILE", "RIVAGE_CLIENT_WORKERS"},
                          known)
              .empty());
    CHECK(unknownVariable({"RIVAGE_PORT", "RIVAGE_SERVICE_HOST", "RIVAGE_SERVER_SERVICE_PORT",
                           "RIVAGE_PORT_80_TCP_ADDR", "RIVAGE_SERVER_SERVICE_PORT_HTTP"},
                          known)
              .empty());
    CHECK_FALSE(unknownVariable({"RIVAGE_NONSENSE"}, known).empty());
}

TEST_CASE("settings: --help and --version end well") {
    CHECK(run({"--help"}).line.exitCode == 0);
    const Outcome version = run({"--version"});
    CHECK(version.line.exitCode == 0);
    CHECK(version.out.starts_with("rivage-server "));
}

TEST_SUITE_END();
