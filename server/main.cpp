#include <pthread.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <thread>

#include "server/http/admin_server.h"
#include "server/http/http_server.h"
#include "server/ops/engine.h"
#include "server/ops/log.h"
#include "server/ops/machine.h"
#include "server/ops/settings.h"
#include "server/web/assets.h"

namespace {

using namespace rivage::server;
using rivage::core::Error;

/// Signals that ask for the end. They are blocked in every thread and taken by `main` alone, so no
/// handler runs in the middle of anything.
sigset_t stopSignals() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGINT);
    return signals;
}

bool signalled(const sigset_t& signals, std::chrono::milliseconds wait) {
    const timespec time{wait.count() / 1000, wait.count() % 1000 * 1000000};
    return ::sigtimedwait(&signals, nullptr, &time) > 0;
}

[[noreturn]] void endAtOnce(const Address& address) {
    logWarning("killed", {{"reason", "second signal"}});
    removeSocketFile(address);
    std::_Exit(130);
}

/// Lets accepted jobs end, cancels what is left after the time-out, closes the listeners.
void drain(JobPool& pool, HttpServer& http, AdminServer& admin, const Settings& settings,
           const Address& address) {
    const sigset_t signals = stopSignals();
    logInfo("draining", {{"timeout_s", settings.drainTimeout.count()}});
    pool.beginDraining();
    const auto until = Clock::now() + settings.drainTimeout;
    while (!pool.idle() && Clock::now() < until)
        if (signalled(signals, std::chrono::milliseconds(20))) endAtOnce(address);
    if (!pool.idle()) {
        logWarning("canceling", {{"jobs", pool.stats().running + pool.stats().queued}});
        pool.stopAll();
    }
    std::atomic<bool> stopped{false};
    std::thread stopper([&] {
        http.stop();
        admin.stop();
        stopped = true;
    });
    while (!stopped)
        if (signalled(signals, std::chrono::milliseconds(20))) endAtOnce(address);
    stopper.join();
}

int refuse(const Error& error) {
    logWarning("cannot start", {{"reason", error.message}});
    return 1;
}

int serve(const Settings& settings) {
    const sigset_t signals = stopSignals();
    ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    tuneMemory();

    JobPool pool(settings.pool(), coreEngine(), logJob);
    Service service{
        .pool = pool, .limits = settings.limits(), .samples = coreSamples(), .assets = webAssets()};
    HttpSettings httpSettings{.observer = logRequest};
    httpSettings.net.connections = settings.connections;
    HttpServer http(httpSettings, service);
    AdminServer admin(service);

    if (settings.adminListen != "off") {
        auto listener = listenOn(*parseAddress(settings.adminListen));
        if (!listener) return refuse(listener.error());
        const std::string url = listener->address.url();
        if (auto started = admin.start(*std::move(listener)); !started)
            return refuse(started.error());
        logInfo("admin", {{"address", url}});
    }
    auto listener = listenOn(*parseAddress(settings.listen));
    if (!listener) return refuse(listener.error());
    const Address bound = listener->address;
    if (auto started = http.start(*std::move(listener)); !started) return refuse(started.error());
    std::cout << "listening on " << bound.url() << std::endl;
    logInfo("started", {{"address", bound.url()},
                        {"workers", settings.workers},
                        {"threads_per_job", settings.threadsPerJob},
                        {"queue_limit", settings.queueLimit},
                        {"memory_budget", settings.memoryBudget}});

    int signal = 0;
    ::sigwait(&signals, &signal);
    drain(pool, http, admin, settings, bound);
    removeSocketFile(bound);
    logInfo("stopped", rivage::proto::Json::object());
    return 0;
}

}  // namespace

int main(int count, char** arguments) {
    const CommandLine line = readCommandLine(count, arguments);
    if (line.exitCode) return *line.exitCode;
    setUpLog(line.settings.logFormat, line.settings.logLevel);
    return serve(line.settings);
}
