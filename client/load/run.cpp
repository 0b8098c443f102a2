#include "client/load/run.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>

#include "client/load/units.h"

namespace rivage::client::load {
namespace {

using namespace std::chrono_literals;

/// All threads are there before the first send is due.
constexpr auto kHeadStart = 100ms;
/// More late sends than this share, and a run says nothing.
constexpr double kMaxLate = 0.01;

/// The threads of one run.
class Crew {
public:
    Crew(const LoadPlan& plan, Series& series, Verifier& verifier) {
        const TimePoint start = Clock::now() + kHeadStart;
        for (int i = 0; i < plan.threads; ++i)
            generators_.push_back(std::make_unique<Generator>(plan, i, start, series, verifier));
        for (const auto& generator : generators_)
            threads_.emplace_back([this, one = generator.get()] {
                one->run(stop_);
                ++done_;
            });
    }
    ~Crew() {
        stop();
        for (std::thread& thread : threads_) thread.join();
    }
    Crew(const Crew&) = delete;
    Crew& operator=(const Crew&) = delete;

    void stop() { stop_ = true; }
    [[nodiscard]] bool done() const { return done_ == threads_.size(); }
    /// After the end.
    void collect(LoadResult& result, double& cpu) const {
        for (const auto& generator : generators_) {
            result.tally.merge(generator->tally());
            result.connections += generator->connections();
            result.bytesIn += generator->bytesIn();
            result.bytesOut += generator->bytesOut();
            cpu = std::max(cpu, generator->busy());
        }
    }

private:
    std::vector<std::unique_ptr<Generator>> generators_;
    std::vector<std::thread> threads_;
    std::atomic<bool> stop_{false};
    std::atomic<std::size_t> done_{0};
};

/// Waits for the end of a crew, asking the observer meanwhile.
bool watchCrew(Crew& crew, Interrupt& interrupt, const LoadObserver& observe,
               const Series& series) {
    bool interrupted = false;
    while (!crew.done()) {
        // After a stop nothing is slept for: the crew ends within a moment.
        if (!interrupted && !interrupt.sleep(50ms)) {
            interrupted = true;
            crew.stop();
        }
        if (interrupted) std::this_thread::sleep_for(5ms);
        if (observe && !observe(series)) crew.stop();
    }
    return interrupted;
}

}  // namespace

double LoadResult::offered() const {
    return duration <= 0 ? 0 : static_cast<double>(tally.planned) / duration;
}

double LoadResult::goodput() const {
    std::uint64_t wrong = 0;
    for (const char* name : {"digest-mismatch", "invalid-glb", "different-result"}) {
        const auto found = tally.errors.find(name);
        if (found != tally.errors.end()) wrong += found->second;
    }
    const std::uint64_t right = tally.withinSlo - std::min(wrong, tally.withinSlo);
    return duration <= 0 ? 0 : static_cast<double>(right) / duration;
}

GeneratorHealth judgeHealth(const LoadPlan& plan, const Tally& tally, double cpu) {
    GeneratorHealth health;
    health.cpu = cpu;
    health.notSent = tally.notSent();
    if (tally.sent > 0)
        health.lateShare = static_cast<double>(tally.late) / static_cast<double>(tally.sent);
    if (plan.arrivals.kind == Arrivals::closed) return health;
    if (health.lateShare <= kMaxLate) return health;
    health.valid = false;
    health.reason = numberText(100 * health.lateShare, 1) +
                    " % of the sends were late; give the generator more --threads, a processor of "
                    "its own (--pin), or a lower rate";
    return health;
}

LoadResult runLoad(const LoadPlan& plan, Interrupt& interrupt, const LoadObserver& observe,
                   const std::optional<ServerAccess>& admin) {
    LoadResult result;
    Series series;
    Verifier verifier;
    double cpu = 0;
    std::optional<MetricsPoll> metrics;
    if (admin) metrics.emplace(*admin);
    {
        Crew crew(plan, series, verifier);
        result.interrupted = watchCrew(crew, interrupt, observe, series);
        crew.collect(result, cpu);
    }
    if (metrics) result.metrics = metrics->stop();
    verifier.finish();
    result.verified = verifier.verified();
    result.unverified = verifier.skipped();
    for (const auto& [name, count] : verifier.faults()) {
        result.tally.errors[name] += count;
        result.tally.good -= std::min(count, result.tally.good);
        result.tally.failed += count;
    }
    result.seconds = series.all();
    const auto asked = static_cast<double>(plan.duration.count());
    const auto seen = static_cast<double>(result.seconds.size());
    const bool shortened = result.interrupted || seen + 1 < asked;
    result.duration = shortened ? seen : asked;
    result.health = judgeHealth(plan, result.tally, cpu);
    return result;
}

}  // namespace rivage::client::load
