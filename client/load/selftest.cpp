#include "client/load/selftest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "client/load/stub_server.h"
#include "client/load/units.h"

namespace rivage::client::load {
namespace {

constexpr std::int64_t kStall = 1'000'000;  // us

/// What all checks share.
struct Bench {
    const SelftestPlan& plan;
    Interrupt& interrupt;
    std::string& trouble;  ///< what kept the last run from being one

    [[nodiscard]] LoadResult run(const StubServer& stub, const ArrivalPlan& arrivals,
                                 double seconds) const {
        auto load = plainLoad(stub.url(), arrivals, seconds);
        if (!load) {
            trouble = describe(load.error());
            return {};
        }
        load->pins = plan.pins;
        LoadResult result = runLoad(*load, interrupt);
        if (result.health.shortage.count > 0) trouble = result.health.reason;
        return result;
    }
};

StubSettings stalling() {
    return {.stallAt = std::chrono::duration<double>(1),
            .stallFor = std::chrono::duration<double>(1)};
}

std::string percentiles(const Histogram& histogram) {
    if (histogram.count() == 0) return "n/a";
    return "p50 " + timeText(histogram.valueAt(50)) + ", p99 " + timeText(histogram.valueAt(99)) +
           ", max " + timeText(histogram.max());
}

/// The classic of coordinated omission: who waits for answers before asking again hides a stall.
SelftestCheck checkOpenStall(const Bench& bench) {
    const StubServer stub(stalling());
    const double seconds = bench.plan.brief ? 3 : 6;
    const auto result = bench.run(stub, {.kind = Arrivals::constant, .rate = 200}, seconds);
    const Histogram& latency = result.tally[Measure::corrected];
    return {"a stall of 1 s shows in an open loop", "corrected: " + percentiles(latency),
            latency.count() > 100 && latency.valueAt(99) > kStall * 8 / 10 &&
                latency.max() > kStall * 9 / 10};
}

SelftestCheck checkClosedStall(const Bench& bench) {
    const StubServer stub(stalling());
    const double seconds = bench.plan.brief ? 3 : 6;
    const auto result = bench.run(stub, {.kind = Arrivals::closed, .concurrency = 1}, seconds);
    const Histogram& latency = result.tally[Measure::corrected];
    return {"and is hidden by a closed loop", percentiles(latency),
            latency.count() > 100 && latency.valueAt(99) < kStall / 10 &&
                latency.max() > kStall * 9 / 10};
}

SelftestCheck checkHistogram() {
    std::mt19937_64 random(1);
    std::lognormal_distribution<double> draw(9, 2);
    std::vector<std::int64_t> exact;
    Histogram histogram;
    for (int i = 0; i < 200'000; ++i) {
        exact.push_back(std::clamp<std::int64_t>(std::llround(draw(random)), Histogram::kLowest,
                                                 Histogram::kHighest));
        histogram.record(exact.back());
    }
    std::sort(exact.begin(), exact.end());
    double worst = 0;
    for (const double percent : {1.0, 50.0, 90.0, 99.0, 99.9, 99.99}) {
        const auto rank = static_cast<std::size_t>(
            std::ceil(percent / 100 * static_cast<double>(exact.size()) - 1e-6));
        const auto value = static_cast<double>(exact[rank - 1]);
        const auto told = static_cast<double>(histogram.valueAt(percent));
        worst = std::max(worst, std::abs(told - value) / value);
    }
    return {"the histogram keeps three digits",
            "200000 values: off by " + numberText(100 * worst, 3) + " % at most", worst <= 0.001};
}

SelftestCheck checkPrecision(const Bench& bench) {
    const StubServer stub({});
    const double seconds = bench.plan.brief ? 1 : 5;
    const auto result = bench.run(stub, {.kind = Arrivals::poisson, .rate = 1000}, seconds);
    const Histogram& lag = result.tally[Measure::lag];
    return {"sends are within 1 ms of their time",
            "1000/s: send lag " + percentiles(lag) + ", late " +
                numberText(100 * result.health.lateShare, 2) + " %",
            lag.count() > 100 && lag.valueAt(99) <= 1000 && result.health.valid, !bench.plan.brief};
}

SelftestCheck checkRate(const Bench& bench) {
    const StubServer stub({});
    const double rate = bench.plan.rate;
    const double seconds = bench.plan.brief ? 1 : 5;
    const auto result = bench.run(stub, {.kind = Arrivals::constant, .rate = rate}, seconds);
    const Tally& tally = result.tally;
    return {"one thread sends " + numberText(rate, 0) + "/s in time",
            numberText(result.goodput(), 0) + "/s, send lag " + percentiles(tally[Measure::lag]) +
                ", late " + numberText(100 * result.health.lateShare, 2) + " %, CPU " +
                numberText(100 * result.health.cpu, 0) + " %",
            result.health.valid && tally.failed == 0 && result.goodput() >= 0.99 * rate,
            !bench.plan.brief};
}

/// What a command prints; empty if it fails.
std::string outputOf(const std::string& command) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    std::string output;
    std::array<char, 4096> buffer{};
    while (pipe && !std::feof(pipe.get()))
        output.append(buffer.data(), std::fread(buffer.data(), 1, buffer.size(), pipe.get()));
    return output;
}

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

/// Closed loops of wrk and of our own, one after the other several times: what else the machine
/// does meets both.
SelftestCheck checkWrk(const Bench& bench) {
    const int connections = 8;
    // With a server that is faster than both, each would only measure itself.
    const StubServer stub({.work = std::chrono::microseconds(20)});
    const std::string processor =
        bench.plan.pins.empty() ? ""
                                : "taskset -c " + std::to_string(bench.plan.pins.front()) + " ";
    const std::string command = processor + "wrk -t1 -c" + std::to_string(connections) + " -d2s " +
                                stub.url() + "/ 2>/dev/null";
    std::vector<double> theirs;
    std::vector<double> ours;
    std::vector<double> ratios;
    for (int round = 0; round < (bench.plan.brief ? 1 : 5); ++round) {
        theirs.push_back(readWrk(outputOf(command)));
        const ArrivalPlan closed{.kind = Arrivals::closed, .concurrency = connections};
        ours.push_back(bench.run(stub, closed, 2).goodput());
        if (theirs.back() > 0) ratios.push_back(ours.back() / theirs.back());
        if (bench.interrupt.requested()) break;
    }
    if (ratios.empty()) return {"wrk finds the same", "wrk is not installed", true, false};
    return {"wrk finds the same",
            numberText(median(ours), 0) + "/s, wrk " + numberText(median(theirs), 0) +
                "/s; ratio " + numberText(median(ratios), 3),
            std::abs(median(ratios) - 1) <= 0.1, !bench.plan.brief};
}

}  // namespace

double readWrk(const std::string& output) {
    const std::size_t at = output.find("Requests/sec:");
    return at == std::string::npos ? 0 : std::strtod(output.c_str() + at + 13, nullptr);
}

Outcome<LoadPlan> plainLoad(const std::string& url, const ArrivalPlan& arrivals, double seconds) {
    const auto endpoint = parseEndpoint(url);
    if (!endpoint) return tl::unexpected(endpoint.error());
    auto target = resolveTarget(*endpoint);
    if (!target) return tl::unexpected(target.error());
    Interrupt none;
    auto mix = prepareMix(plainMix("/"), {*endpoint}, *target, none);
    if (!mix) return tl::unexpected(mix.error());
    LoadPlan plan{*std::move(target), *std::move(mix), arrivals};
    plan.warmup = std::chrono::duration<double>(0.2);
    plan.duration = std::chrono::duration<double>(seconds);
    plan.verify = 0;
    return plan;
}

std::vector<SelftestCheck> runSelftest(const SelftestPlan& plan, Interrupt& interrupt,
                                       const std::function<void(const SelftestCheck&)>& say) {
    std::string trouble;
    const Bench bench{plan, interrupt, trouble};
    std::vector<std::function<SelftestCheck()>> checks{
        [&] { return checkHistogram(); }, [&] { return checkOpenStall(bench); },
        [&] { return checkClosedStall(bench); }, [&] { return checkPrecision(bench); },
        [&] { return checkRate(bench); }};
    if (plan.wrk) checks.emplace_back([&] { return checkWrk(bench); });
    std::vector<SelftestCheck> done;
    for (const auto& check : checks) {
        if (interrupt.requested()) break;
        trouble.clear();
        done.push_back(check());
        if (!trouble.empty()) done.back().figures += "; " + trouble;
        say(done.back());
    }
    return done;
}

}  // namespace rivage::client::load
