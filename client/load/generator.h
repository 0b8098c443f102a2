#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <queue>
#include <random>
#include <vector>

#include "client/load/carrier.h"
#include "client/load/flow.h"
#include "client/load/schedule.h"
#include "client/load/verifier.h"

namespace rivage::client::load {

/// Everything that a run is made of.
struct LoadPlan {
    Target target;
    PreparedMix mix;
    ArrivalPlan arrivals;
    std::chrono::duration<double> warmup{1};     ///< sent, but not counted
    std::chrono::duration<double> duration{10};  ///< after the warm-up
    CarrierLimits limits;
    std::int64_t sloLimit = Histogram::kHighest;  ///< us, what goodput counts
    double verify = 0.05;                         ///< share of the good answers
    std::uint64_t seed = 1;
    int threads = 1;
    std::vector<int> pins = {};  ///< the processor of each thread; empty: any
    std::uint64_t maxRequests = 10'000'000;
};

/// The share of a run that one thread does.
class Generator : ExchangeListener, FlowHost {
public:
    /// @param plan   must outlive the generator
    /// @param start  the beginning of the warm-up, for all threads the same
    Generator(const LoadPlan& plan, int thread, TimePoint start, Series& series,
              Verifier& verifier);
    ~Generator() override;

    /// Sends until the plan is done, or until `stop`, and then waits for what is under way. Sends
    /// nothing if there are no descriptors for what it needs itself.
    void run(const std::atomic<bool>& stop);

    /// After `run`.
    [[nodiscard]] const Tally& tally() const { return tally_; }
    /// The share of the measured time that this thread used a processor, without what it waited
    /// for the exact moment of a send; 0..1.
    [[nodiscard]] double busy() const { return busy_; }
    /// What this machine had too little of, in the warm-up too.
    [[nodiscard]] const Shortage& shortage() const { return carrier_.shortage(); }
    [[nodiscard]] std::uint64_t connections() const { return carrier_.opened(); }
    [[nodiscard]] std::uint64_t bytesIn() const { return carrier_.bytesIn(); }
    [[nodiscard]] std::uint64_t bytesOut() const { return carrier_.bytesOut(); }

private:
    struct Wake {
        TimePoint at;
        std::size_t slot;
        std::uint64_t generation;
        bool operator>(const Wake& other) const { return at > other.at; }
    };

    void grown(Exchange& exchange) override;
    void ended(Exchange& exchange) override;
    void send(Flow& flow) override;
    void breakOff(Flow& flow) override;
    void wake(Flow& flow, TimePoint at) override;
    void finish(Flow& flow) override;
    const HeadWriter& heads() override { return plan_.mix.heads; }
    Tally& tally(const Flow& flow) override;
    void verify(const Flow& flow) override;

    void prepare();
    bool step(bool stopped);
    bool launchDue(TimePoint now);
    void launch(TimePoint planned, int entry);
    FlowDraw drawFlow(const MixEntry& entry);
    int drawEntry();
    bool chance(double probability);
    void runWakes(TimePoint now);
    void giveUp();
    void readClocks(TimePoint now);
    void rollSecond(TimePoint now);
    [[nodiscard]] bool measured(const Flow& flow) const;
    [[nodiscard]] TimePoint nextDue() const;
    void count(const Flow& flow);
    void countGood(const Flow& flow);
    void countSent(const Flow& flow);

    const LoadPlan& plan_;
    const int thread_;
    const TimePoint start_;
    const TimePoint measureFrom_;
    const TimePoint measureTo_;
    std::chrono::nanoseconds lateLimit_{0};
    Series& series_;
    Verifier& verifier_;
    Carrier carrier_;
    std::mt19937_64 random_;
    std::discrete_distribution<int> weights_;
    std::unique_ptr<Schedule> schedule_;  ///< null: closed loop
    Arrival next_;
    std::priority_queue<TimePoint, std::vector<TimePoint>, std::greater<>> restarts_;
    std::priority_queue<Wake, std::vector<Wake>, std::greater<>> wakes_;
    std::vector<std::unique_ptr<Flow>> flows_;
    std::vector<std::size_t> freeSlots_;
    std::vector<std::unique_ptr<Flow>> ended_;  ///< gone when nobody is inside of them
    std::size_t active_ = 0;
    std::uint64_t generations_ = 0;
    std::uint64_t launched_ = 0;
    bool stopped_ = false;
    Tally tally_;
    Tally unmeasured_;
    Second second_;
    std::size_t secondIndex_ = 0;
    std::uint64_t bytesBefore_ = 0;
    std::chrono::nanoseconds spun_{0};
    std::chrono::nanoseconds cpuBefore_{0};
    TimePoint clockFrom_;
    double busy_ = 0;
};

}  // namespace rivage::client::load
