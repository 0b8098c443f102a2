#include "server/serving.h"

#include <pthread.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <iostream>
#include <thread>
#include <utility>

#include "server/http/admin_server.h"
#include "server/http/http_server.h"
#include "server/jobs/disk_blob_store.h"
#include "server/jobs/sqlite_job_store.h"
#include "server/net/tls.h"
#include "server/ops/log.h"
#include "server/ops/machine.h"
#include "server/ops/metrics.h"
#include "server/ops/signals.h"
#include "server/web/assets.h"

namespace rivage::server {
namespace {

using namespace std::chrono_literals;
using core::fail;

/// How often the server looks whether a worker is stuck.
constexpr auto kLook = 250ms;

/// Threads for requests that wait for nothing.
constexpr std::size_t kQuickHandlers = 64;

/// The exit code of a server whose worker is stuck; its supervisor starts another.
constexpr int kStuck = 70;

/// What keeps jobs for the next process; null without a state folder.
struct Stores {
    std::unique_ptr<BlobStore> blobs;
    std::unique_ptr<JobStore> jobs;
};

core::Result<Stores> openStores(const std::string& folder) {
    Stores stores;
    if (folder.empty()) return stores;
    auto blobs = openDiskBlobStore(folder);
    if (!blobs) return fail(blobs.error());
    auto jobs = openSqliteJobStore(folder);
    if (!jobs) return fail(jobs.error());
    stores.blobs = *std::move(blobs);
    stores.jobs = *std::move(jobs);
    return stores;
}

PoolSettings poolSettings(const Settings& settings) {
    PoolSettings pool = settings.pool();
    pool.watchdog = settings.watchdog;
    return pool;
}

HttpSettings httpSettings(const Settings& settings, Metrics& metrics) {
    HttpSettings http;
    http.net.connections = settings.connections;
    // Those who wait must never leave none for quick requests.
    http.net.handlers = settings.workers + settings.queueLimit + settings.longPolls +
                        settings.streams + kQuickHandlers;
    http.net.headTimeout = settings.headerTimeout;
    http.net.bodyTimeout = settings.bodyTimeout;
    http.net.leastRate = settings.minBodyRate;
    // Chunks of a few bytes and trailers without end are no grids.
    http.net.bodyBytes = 2 * settings.maxUpload + (std::uint64_t{1} << 20);
    http.net.writeGrace = settings.writeTimeout;
    http.net.idleTimeout = settings.idleTimeout;
    http.trustedProxies = settings.trustedProxies;
    http.observer = [&metrics](const RequestRecord& record) {
        logRequest(record);
        metrics.requestEnded(record);
    };
    return http;
}

/// The parts that serve, in the order in which they depend on each other.
class Server {
public:
    Server(const Serving& serving, const Stores& stores)
        : serving_(serving),
          pool_(poolSettings(serving.settings), serving.engine,
                [this](const JobFacts& facts, const JobSnapshot& job) {
                    logJob(facts, job);
                    metrics_.jobEnded(job);
                },
                {stores.blobs.get(), stores.jobs.get(), &serving.crashes}),
          service_{.pool = pool_,
                   .limits = serving.settings.limits(),
                   .samples = serving.samples,
                   .assets = webAssets(),
                   .longPolls = serving.settings.longPolls,
                   .streams = serving.settings.streams,
                   .restarts = serving.supervision.restarts},
          http_(httpSettings(serving.settings, metrics_), service_),
          admin_(service_) {}

    core::Result<void> start();
    void run();

private:
    core::Result<void> loadTls();
    core::Result<void> loadKeys();
    void announce() const;
    SignalRequest nextRequest(std::chrono::milliseconds wait);
    void reload();
    void drain(bool soon);
    void stopListening();
    [[noreturn]] void endAtOnce() const;

    const Serving& serving_;
    Metrics metrics_;
    JobPool pool_;
    Service service_;
    std::unique_ptr<TlsContext> tls_;
    HttpServer http_;
    AdminServer admin_;
    SignalReader signals_;
};

core::Result<void> Server::start() {
    service_.uploads.limit = serving_.settings.uploadBytes();
    service_.corsOrigins = serving_.settings.corsOrigins;
    service_.metrics = [this] { return metrics_.text(service_); };
    service_.net = &http_.front().stats();
    service_.loopBeat = [this] { return http_.front().lastBeat(); };
    if (const auto& recovered = pool_.recovered(); !recovered) return recovered;
    if (auto loaded = loadTls(); !loaded) return loaded;
    if (auto loaded = loadKeys(); !loaded) return loaded;
    if (serving_.admin) {
        auto shared = share(*serving_.admin);
        if (!shared) return fail(shared.error());
        if (auto started = admin_.start(*std::move(shared)); !started) return fail(started.error());
    }
    auto shared = share(serving_.http);
    if (!shared) return fail(shared.error());
    if (auto started = http_.start(*std::move(shared), tls_.get()); !started)
        return fail(started.error());
    return {};
}

core::Result<void> Server::loadTls() {
    const Settings& settings = serving_.settings;
    if (settings.tlsCert.empty()) return {};
    auto tls = TlsContext::load(settings.tlsCert, settings.tlsKey);
    if (!tls) return fail(tls.error());
    tls_ = *std::move(tls);
    service_.onReload.emplace_back([this] { return tls_->reload(); });
    return {};
}

core::Result<void> Server::loadKeys() {
    const Settings& settings = serving_.settings;
    if (settings.apiKeys.empty()) return {};
    auto ring = KeyRing::load(settings.apiKeys);
    if (!ring) return fail(ring.error());
    service_.access = std::make_shared<Access>(std::make_shared<const KeyRing>(*std::move(ring)));
    service_.onReload.emplace_back(
        [this, path = settings.apiKeys] { return service_.access->reload(path); });
    return {};
}

/// Says where it listens; to programs that wait for it, once and not after each restart. With a
/// log of JSON every line is JSON, and the line "started" says it.
void Server::announce() const {
    const Settings& settings = serving_.settings;
    std::string url = serving_.http.address.url();
    if (tls_ && url.starts_with("http:")) url.insert(4, "s");
    if (serving_.admin) logInfo("admin", {{"address", serving_.admin->address.url()}});
    if (service_.restarts == 0 && settings.logFormat == LogFormat::text)
        std::cout << "listening on " << url << std::endl;
    logInfo("started", {{"pid", ::getpid()},
                        {"restarts", service_.restarts},
                        {"address", url},
                        {"workers", settings.workers},
                        {"threads_per_job", settings.threadsPerJob},
                        {"queue_limit", settings.queueLimit},
                        {"memory_budget", settings.memoryBudget}});
}

void Server::run() {
    serving_.supervision.started = true;
    announce();
    SignalRequest request = SignalRequest::none;
    while (request == SignalRequest::none) request = nextRequest(kLook);
    drain(request == SignalRequest::stopSoon);
}

/// What a signal asks for, apart from reloading, which is done, and the end, which is the end. So
/// is a worker that is stuck: what runs then counts as running at a crash.
SignalRequest Server::nextRequest(std::chrono::milliseconds wait) {
    const SignalRequest request = signals_.next(wait);
    if (pool_.stuck()) {
        logWarning("stuck", {{"pid", ::getpid()}, {"reason", "a job ignores its deadline"}});
        std::_Exit(kStuck);
    }
    if (request == SignalRequest::end) endAtOnce();
    if (request != SignalRequest::reload) return request;
    reload();
    return SignalRequest::none;
}

/// Every part reads its files again, or goes on with what it had.
void Server::reload() {
    for (const auto& part : service_.onReload)
        if (const auto reloaded = part(); !reloaded)
            logWarning("not reloaded", {{"reason", reloaded.error().message}});
    logInfo("reloaded", {{"parts", service_.onReload.size()}});
}

/// Unready at once; then serves on until load balancers have seen that; then takes no new jobs,
/// lets accepted ones end, and cancels what is left after the time-out.
void Server::drain(bool soon) {
    const auto waitUntil = [&](std::chrono::milliseconds time, const auto& done) {
        for (const auto until = Clock::now() + time; !done() && Clock::now() < until;)
            nextRequest(20ms);
    };
    const auto delay = soon ? 0s : serving_.settings.drainDelay;
    logInfo("draining",
            {{"delay_s", delay.count()}, {"timeout_s", serving_.settings.drainTimeout.count()}});
    service_.unready = true;
    waitUntil(delay, [] { return false; });
    pool_.beginDraining();
    waitUntil(serving_.settings.drainTimeout, [&] { return pool_.idle(); });
    if (!pool_.idle()) {
        logWarning("stopping", {{"jobs", pool_.stats().unfinished}});
        pool_.stopAll();
    }
    stopListening();
    logInfo("stopped", {{"pid", ::getpid()}});
}

void Server::stopListening() {
    std::atomic<bool> stopped{false};
    std::thread stopper([&] {
        http_.stop();
        admin_.stop();
        stopped = true;
    });
    while (!stopped) nextRequest(20ms);
    stopper.join();
}

void Server::endAtOnce() const {
    logWarning("killed", {{"reason", "second signal"}});
    serving_.crashes.clear();
    if (!serving_.settings.supervise) serving_.http.remove();
    std::_Exit(130);
}

int refuse(const core::Error& error) {
    logWarning("cannot start", {{"reason", error.message}});
    return 1;
}

}  // namespace

int serveUntilStopped(const Serving& serving) {
    const sigset_t signals = servingSignals();
    ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    tuneMemory();
    const auto stores = openStores(serving.settings.stateDir);
    if (!stores) return refuse(stores.error());
    if (const std::size_t inputs = serving.crashes.recover(); inputs > 0)
        logWarning("crash recovered", {{"inputs", inputs}});
    Server server(serving, *stores);
    if (const auto started = server.start(); !started) return refuse(started.error());
    server.run();
    return 0;
}

}  // namespace rivage::server
