#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "client/load/command_line.h"
#include "client/load/environment.h"
#include "client/load/input_file.h"
#include "client/load/output_folder.h"
#include "client/load/plot.h"
#include "client/load/report.h"
#include "client/load/search.h"
#include "client/load/stub_server.h"
#include "client/printable.h"

namespace rivage::client::load {
namespace {

constexpr std::size_t kMostMix = std::size_t{16} << 20;
/// Some millions of requests.
constexpr std::size_t kMostTrace = std::size_t{64} << 20;

/// Everything that is known before the first request.
struct Setup {
    LoadPlan plan;
    ServerAccess server;
    std::optional<ServerAccess> admin;
    std::optional<Slo> slo;
    proto::Json environment;
    proto::Json version;
};

LoadExit complain(Console& console, const Failure& failure) {
    console.err << "rivage-load: " << describe(failure) << "\n";
    return exitOf(failure);
}

Outcome<ServerAccess> accessOf(const LoadOptions& options, const std::string& url) {
    const auto endpoint = parseEndpoint(url);
    if (!endpoint) return tl::unexpected(endpoint.error());
    auto key = apiKeyOf(options.apiKeyFile);
    if (!key) return tl::unexpected(key.error());
    return ServerAccess{*endpoint, *std::move(key), options.caFile};
}

Outcome<Target> targetOf(const LoadOptions& options, const Endpoint& endpoint) {
    auto target = resolveTarget(endpoint, options.caFile);
    if (target && !target->local && !options.ownThis)
        return fail(ExitCode::usage, "This server is on another machine",
                    "a load test can look like an attack: say --i-own-this if it may be tested");
    return target;
}

Outcome<Mix> mixOf(const LoadOptions& options, const Interrupt& interrupt) {
    if (!options.get.empty()) {
        const bool plain = std::all_of(options.get.begin(), options.get.end(),
                                       [](char c) { return c > 0x20 && c < 0x7f; });
        if (plain && options.get.starts_with('/')) return plainMix(options.get);
        return fail(ExitCode::usage, "The path of --get cannot be used",
                    "expected a path that begins with /, without blanks, control characters and "
                    "non-ASCII");
    }
    if (options.mix.empty()) return defaultMix();
    const auto text = readInput("mix", options.mix, {.bytes = kMostMix}, interrupt);
    if (!text) return tl::unexpected(text.error());
    return parseMix(*text, options.mix);
}

Outcome<ArrivalPlan> arrivalsOf(const LoadOptions& options, const Mix& mix,
                                const Interrupt& interrupt) {
    ArrivalPlan plan{.rate = options.rate, .concurrency = options.concurrency};
    if (options.rate > 0) {
        plan.kind = options.poisson ? Arrivals::poisson : Arrivals::constant;
    } else if (!options.replay.empty()) {
        plan.kind = Arrivals::replay;
        const auto text = readInput("trace", options.replay, {.bytes = kMostTrace}, interrupt);
        if (!text) return tl::unexpected(text.error());
        auto trace = parseTrace(*text, mix.names());
        if (!trace) return tl::unexpected(trace.error());
        plan.trace = *std::move(trace);
    }
    return plan;
}

Outcome<std::optional<Slo>> sloOf(const LoadOptions& options, const Mix& mix) {
    if (options.slo.empty()) return mix.slo;
    const auto slo = readSlo(options.slo);
    if (slo) return slo;
    return fail(ExitCode::usage, "--slo cannot be read", kSloForm);
}

void fillPlan(LoadPlan& plan, const LoadOptions& options) {
    plan.warmup = std::chrono::duration<double>(options.warmup);
    plan.duration = std::chrono::duration<double>(options.duration);
    // A replay has its own times: nothing of it is warm-up.
    if (plan.arrivals.kind == Arrivals::replay) plan.warmup = std::chrono::duration<double>(0);
    plan.limits.connections = options.connections;
    plan.limits.timeout =
        std::chrono::milliseconds(static_cast<std::int64_t>(1000 * options.timeout));
    plan.limits.keepAlive = !options.noKeepAlive;
    plan.verify = options.verify;
    plan.threads = options.threads;
    plan.pins = options.pins;
    plan.maxRequests = options.maxRequests;
    const bool fromMix = plan.mix.mix.seed && !options.seedGiven;
    plan.seed = fromMix ? *plan.mix.mix.seed : options.seed;
}

Outcome<Setup> prepare(const LoadOptions& options, Interrupt& interrupt) {
    // A folder that cannot be had is said now, not after the run.
    if (!options.out.empty())
        if (const auto made = writeFolder(options.out, {}); !made)
            return tl::unexpected(made.error());
    const auto server = accessOf(options, options.server);
    if (!server) return tl::unexpected(server.error());
    auto target = targetOf(options, server->endpoint);
    if (!target) return tl::unexpected(target.error());
    const auto mix = mixOf(options, interrupt);
    if (!mix) return tl::unexpected(mix.error());
    auto arrivals = arrivalsOf(options, *mix, interrupt);
    if (!arrivals) return tl::unexpected(arrivals.error());
    const auto slo = sloOf(options, *mix);
    if (!slo) return tl::unexpected(slo.error());
    std::optional<ServerAccess> admin;
    if (!options.admin.empty()) {
        auto access = accessOf(options, options.admin);
        if (!access) return tl::unexpected(access.error());
        const auto place = targetOf(options, access->endpoint);
        if (!place) return tl::unexpected(place.error());
        admin = *std::move(access);
        admin->apiKey.clear();  // the admin port asks for none
    }
    auto version = serverVersion(*server, interrupt);
    if (!version) return tl::unexpected(version.error());
    auto prepared = prepareMix(*mix, *server, *target, interrupt);
    if (!prepared) return tl::unexpected(prepared.error());
    Setup setup{{*std::move(target), *std::move(prepared), *std::move(arrivals)},
                *server,
                std::move(admin),
                *slo,
                describeEnvironment(options.typed),
                *std::move(version)};
    fillPlan(setup.plan, options);
    if (*slo) setup.plan.sloLimit = (*slo)->limit;
    return setup;
}

/// One line on a terminal that says how the run goes.
class LiveLine {
public:
    LiveLine(Console& console, bool wanted) : console_(console), wanted_(wanted) {}
    void show(const Series& series) {
        if (!wanted_ || series.size() == shown_) return;
        shown_ = series.size();
        const Second last = series.between(shown_ - 1, shown_);
        const Histogram latency = last.latency();
        const bool any = latency.count() > 0;
        console_.err << "\r\033[K" << shown_ << " s  " << last.good << "/s good, p50 "
                     << (any ? timeText(latency.valueAt(50)) : "n/a") << ", max "
                     << (any ? timeText(latency.max()) : "n/a") << ", " << last.refused
                     << " refused, " << last.failed << " failed" << std::flush;
    }
    void clear() {
        if (wanted_ && shown_ > 0) console_.err << "\r\033[K" << std::flush;
    }

private:
    Console& console_;
    bool wanted_;
    std::size_t shown_ = 0;
};

/// JSON for a file; bytes that are not UTF-8, as a command line may have, become U+FFFD.
std::string indented(const proto::Json& json) {
    return json.dump(1, ' ', false, proto::Json::error_handler_t::replace) + "\n";
}

Outcome<void> writeReport(const std::string& folder, const LoadReport& report) {
    const Tally& tally = report.result.tally;
    return writeFolder(folder, {{"report.json", indented(reportJson(report))},
                                {"report.md", reportMarkdown(report)},
                                {"seconds.csv", reportCsv(report)},
                                {"corrected.hgrm", tally[Measure::corrected].toHgrm()},
                                {"as_sent.hgrm", tally[Measure::asSent].toHgrm()},
                                {"latency.svg", drawLatency(report.result)}});
}

LoadExit run(const LoadOptions& options, Console& console, Interrupt& interrupt) {
    auto setup = prepare(options, interrupt);
    if (!setup) return complain(console, setup.error());
    LiveLine live(console, console.errIsTerminal && !options.quiet);
    const LoadResult result = runLoad(
        setup->plan, interrupt,
        [&](const Series& series) {
            live.show(series);
            return true;
        },
        setup->admin);
    live.clear();
    const LoadReport report{setup->plan, result,
                            judge(setup->plan.mix.mix.thresholds, setup->slo, result),
                            setup->environment, setup->version};
    console.out << (options.json ? jsonLine(reportJson(report)) : reportTable(report))
                << std::flush;
    if (options.json)  // for the log of a nightly run, where nobody reads the document
        for (const std::string& line : verdictLines(report))
            if (!line.starts_with("kept")) console.err << "rivage-load: " << line << "\n";
    if (!options.out.empty())
        if (const auto written = writeReport(options.out, report); !written)
            return complain(console, written.error());
    return exitOf(result, report.judgements);
}

LoadExit search(const LoadOptions& options, Console& console, Interrupt& interrupt) {
    auto setup = prepare(options, interrupt);
    if (!setup) return complain(console, setup.error());
    SearchPlan plan{.load = setup->plan, .slo = setup->slo.value_or(Slo{99, 500'000})};
    plan.maxErrors = options.maxErrors;
    plan.from = options.from;
    plan.precision = options.precision;
    plan.window = options.window;
    plan.poisson = options.poisson;
    plan.curve = options.curve;
    plan.load.sloLimit = plan.slo.limit;
    const SearchResult result = runSearch(plan, interrupt, [&](const std::string& line) {
        if (!options.quiet) console.err << line << std::endl;
    });
    proto::Json json = searchJson(plan, result);
    json["environment"] = setup->environment;
    json["server"] = setup->version;
    const std::string markdown = curveMarkdown(plan, result);
    json["markdown"] = markdown;
    console.out << (options.json ? jsonLine(json) : markdown) << std::flush;
    if (!options.out.empty()) {
        const auto written =
            writeFolder(options.out, {{"search.json", indented(json)}, {"search.md", markdown}});
        if (!written) return complain(console, written.error());
    }
    return exitOf(result);
}

LoadExit selftest(const LoadOptions& options, Console& console, Interrupt& interrupt) {
    bool kept = true;
    runSelftest(options.selftest, interrupt, [&](const SelftestCheck& check) {
        kept = kept && (check.kept || !check.judged);
        console.out << (!check.judged ? "told    "
                        : check.kept  ? "ok      "
                                      : "FAILED  ")
                    << check.name << ": " << check.figures << std::endl;
    });
    if (interrupt.requested()) return LoadExit::cancelled;
    return kept ? LoadExit::ok : LoadExit::missed;
}

LoadExit stub(const LoadOptions& options, Console& console, Interrupt& interrupt) {
    const StubServer server({.port = options.port,
                             .bodySize = options.bodySize,
                             .work = std::chrono::microseconds(options.workMicroseconds),
                             .stallAt = std::chrono::duration<double>(options.stallAt),
                             .stallFor = std::chrono::duration<double>(options.stallFor)});
    if (server.port() == 0) {
        console.err << "rivage-load: "
                    << (options.port == 0 ? "no port" : "port " + std::to_string(options.port))
                    << " can be used: " << std::strerror(errno) << "\n";
        return LoadExit::usage;
    }
    console.out << "listening on " << server.url() << std::endl;
    if (!console.out) return LoadExit::ok;  // the caller says what is wrong
    while (interrupt.sleep(std::chrono::hours(1))) {
    }
    return LoadExit::ok;
}

LoadExit dispatch(const LoadOptions& options, Console& console, Interrupt& interrupt) {
    if (options.command == LoadCommand::run || options.command == LoadCommand::search ||
        options.command == LoadCommand::selftest)
        prepareProcess(options.nice);
    switch (options.command) {
        case LoadCommand::run: return run(options, console, interrupt);
        case LoadCommand::search: return search(options, console, interrupt);
        case LoadCommand::selftest: return selftest(options, console, interrupt);
        case LoadCommand::stub: return stub(options, console, interrupt);
        case LoadCommand::man: console.out << loadManPage(); return LoadExit::ok;
        case LoadCommand::completions:
            console.out << loadCompletions(options.shell);
            return LoadExit::ok;
    }
    return LoadExit::usage;
}

}  // namespace

LoadExit runLoadCommand(const LoadOptions& options, Console& console, Interrupt& interrupt) {
    const LoadExit exit = dispatch(options, console, interrupt);
    // What was measured is lost with the report; why nothing was measured is not.
    const bool reported =
        exit == LoadExit::ok || exit == LoadExit::missed || exit == LoadExit::late;
    if (!reported || outputArrived(console, "rivage-load")) return exit;
    return LoadExit::notWritten;
}

}  // namespace rivage::client::load
