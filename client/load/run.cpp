#include "client/load/run.h"

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <system_error>
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
        try {
            for (const auto& generator : generators_)
                threads_.emplace_back([this, one = generator.get()] {
                    one->run(stop_);
                    if (one->shortage().count > 0) stop();
                    ++done_;
                });
        } catch (const std::system_error&) {  // no more threads: those that began have to end
            end();
            throw;
        }
    }
    ~Crew() { end(); }
    Crew(const Crew&) = delete;
    Crew& operator=(const Crew&) = delete;

    void stop() { stop_ = true; }
    [[nodiscard]] bool done() const { return done_ == threads_.size(); }
    /// After the end.
    void collect(LoadResult& result, GeneratorHealth& health) const {
        for (const auto& generator : generators_) {
            result.tally.merge(generator->tally());
            result.connections += generator->connections();
            result.bytesIn += generator->bytesIn();
            result.bytesOut += generator->bytesOut();
            health.cpu = std::max(health.cpu, generator->busy());
            health.shortage.merge(generator->shortage());
        }
    }

private:
    void end() {
        stop();
        for (std::thread& thread : threads_) thread.join();
    }

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

/// What is wrong, and what the user can do about it.
std::string describeShortage(const Shortage& shortage) {
    const std::string end = "; the run was ended there";
    if (shortage.error == EMFILE) {
        rlimit files{};
        getrlimit(RLIMIT_NOFILE, &files);
        return "the generator ran out of files: a process may have " +
               std::to_string(files.rlim_cur) + " open here (RLIMIT_NOFILE)" + end +
               "; raise the limit (ulimit -Hn, LimitNOFILE= of systemd, --ulimit nofile of "
               "docker), or take fewer --connections";
    }
    if (shortage.error == ENFILE)
        return "this machine ran out of files, of all programs" + end +
               "; raise fs.file-max with sysctl";
    if (shortage.error == EADDRNOTAVAIL)
        return "the generator found no free local port" + end +
               "; leave --no-keep-alive away, take fewer --connections, or widen "
               "net.ipv4.ip_local_port_range with sysctl";
    return std::string("the generator could not open a connection: ") +
           std::strerror(shortage.error) + end;
}

std::string describeLate(const GeneratorHealth& health) {
    std::string text = numberText(100 * health.lateShare, 1) + " % of the sends were late";
    const unsigned cores = std::thread::hardware_concurrency();
    if (health.loadAverage > 0)
        text += "; the load average was " + numberText(health.loadAverage, 1) + " on " +
                std::to_string(cores) + (cores == 1 ? " processor" : " processors") +
                (health.loadAverage > cores ? ": this machine is busy" : "");
    return text +
           "; end what else runs here, or give the generator more --threads, a processor of its "
           "own (--pin), or a lower rate";
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

GeneratorHealth judgeHealth(const LoadPlan& plan, const Tally& tally, const GeneratorHealth& seen) {
    GeneratorHealth health = seen;
    health.notSent = tally.notSent();
    if (tally.sent > 0)
        health.lateShare = static_cast<double>(tally.late) / static_cast<double>(tally.sent);
    const bool late = plan.arrivals.kind != Arrivals::closed && health.lateShare > kMaxLate;
    if (health.shortage.count > 0)
        health.reason = describeShortage(health.shortage);
    else if (late)
        health.reason = describeLate(health);
    health.valid = health.reason.empty();
    return health;
}

LoadResult runLoad(const LoadPlan& plan, Interrupt& interrupt, const LoadObserver& observe,
                   const std::optional<ServerAccess>& admin) {
    LoadResult result;
    Series series;
    Verifier verifier;
    GeneratorHealth health;
    std::optional<MetricsPoll> metrics;
    if (admin) metrics.emplace(*admin);
    {
        Crew crew(plan, series, verifier);
        result.interrupted = watchCrew(crew, interrupt, observe, series);
        crew.collect(result, health);
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
    (void)getloadavg(&health.loadAverage, 1);
    result.health = judgeHealth(plan, result.tally, health);
    return result;
}

}  // namespace rivage::client::load
