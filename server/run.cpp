#include "server/run.h"

#include <iostream>
#include <optional>
#include <utility>

#include "server/jobs/crash_board.h"
#include "server/jobs/file.h"
#include "server/net/listener.h"
#include "server/ops/log.h"
#include "server/ops/settings.h"
#include "server/ops/supervisor.h"
#include "server/serving.h"

namespace rivage::server {
namespace {

using core::fail;

/// What is opened once, before the first serving process: each of them inherits it.
struct Ground {
    Fd stateLock;
    std::unique_ptr<CrashBoard> crashes;
    std::optional<Listener> admin;
    Listener http;
};

core::Result<Ground> openGround(const Settings& settings) {
    Ground ground;
    std::string board;
    if (!settings.stateDir.empty()) {
        auto lock = lockFolder(settings.stateDir);
        if (!lock) return fail(lock.error());
        ground.stateLock = *std::move(lock);
        board = settings.stateDir + "/crashes";
    }
    auto crashes = CrashBoard::open(board, settings.quarantineTtl);
    if (!crashes) return fail(crashes.error());
    ground.crashes = *std::move(crashes);
    if (settings.adminListen != "off") {
        auto admin = listenOn(*parseAddress(settings.adminListen));
        if (!admin) return fail(admin.error());
        ground.admin = *std::move(admin);
    }
    auto http = listenOn(*parseAddress(settings.listen));
    if (!http) return fail(http.error());
    ground.http = *std::move(http);
    return ground;
}

}  // namespace

int runServer(int argc, const char* const* argv, const Engine& engine, const Samples& samples) {
    const CommandLine line = readCommandLine(argc, argv);
    if (line.exitCode) return *line.exitCode;
    const Settings& settings = line.settings;
    setUpLog(settings.logFormat, settings.logLevel);
    const auto ground = openGround(settings);
    if (!ground) {
        logWarning("cannot start", {{"reason", ground.error().message}});
        return 1;
    }
    const auto serve = [&](Supervision& supervision) {
        return serveUntilStopped({.settings = settings,
                                  .engine = engine,
                                  .samples = samples,
                                  .http = ground->http,
                                  .admin = ground->admin ? &*ground->admin : nullptr,
                                  .crashes = *ground->crashes,
                                  .supervision = supervision});
    };
    Supervision alone;
    const int code = settings.supervise ? supervise(serve) : serve(alone);
    ground->http.remove();
    return code;
}

}  // namespace rivage::server
