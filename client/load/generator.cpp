#include "client/load/generator.h"

#include <pthread.h>
#include <sys/prctl.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "client/load/taxonomy.h"

namespace rivage::client::load {
namespace {

using namespace std::chrono_literals;

/// So many sends may be behind before answers are looked at again.
constexpr int kBurst = 64;
/// One round of waiting for the exact moment; what is longer was somebody else's turn.
constexpr auto kLongestSpin = 5us;
/// A closed loop waits so long before it asks again a server that it could not reach.
constexpr auto kReconnectPause = 50ms;

TimePoint after(TimePoint from, std::chrono::duration<double> time) {
    return from + std::chrono::duration_cast<Clock::duration>(time);
}

std::chrono::nanoseconds threadTime() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

/// A send is late if it is later than 1 ms and 1 % of the time between two sends.
std::chrono::nanoseconds lateLimit(const LoadPlan& plan) {
    const ArrivalPlan& arrivals = plan.arrivals;
    std::chrono::duration<double> interval{0};
    if (arrivals.kind == Arrivals::replay) {
        interval = arrivals.trace.back().at / static_cast<double>(arrivals.trace.size());
    } else if (arrivals.rate > 0) {
        interval = std::chrono::duration<double>(1 / arrivals.rate);
    }
    return 1ms + std::chrono::duration_cast<std::chrono::nanoseconds>(interval / 100);
}

std::vector<double> weightsOf(const Mix& mix) {
    std::vector<double> weights;
    for (const MixEntry& entry : mix.entries) weights.push_back(entry.weight);
    return weights;
}

bool neverConnected(Fault fault) {
    return fault == Fault::connectRefused || fault == Fault::connectTimeout ||
           fault == Fault::connectFailed || fault == Fault::tlsFailed || fault == Fault::notSent;
}

}  // namespace

Generator::Generator(const LoadPlan& plan, int thread, TimePoint start, Series& series,
                     Verifier& verifier)
    : plan_(plan),
      thread_(thread),
      start_(start),
      measureFrom_(after(start, plan.warmup)),
      measureTo_(after(measureFrom_, plan.duration)),
      lateLimit_(lateLimit(plan)),
      series_(series),
      verifier_(verifier),
      carrier_(plan_.target, plan.limits, *this),
      random_(plan.seed + 0x9E3779B97F4A7C15U * static_cast<std::uint64_t>(thread + 1)) {
    const auto weights = weightsOf(plan.mix.mix);
    weights_ = std::discrete_distribution<int>(weights.begin(), weights.end());
    tally_.entries.resize(weights.size());
    unmeasured_.entries.resize(weights.size());
}

Generator::~Generator() = default;

void Generator::prepare() {
    // Timers of a thread may otherwise be 50 us late on purpose.
    prctl(PR_SET_TIMERSLACK, 1);
    if (!plan_.pins.empty()) {
        cpu_set_t set;
        CPU_ZERO(&set);
        CPU_SET(plan_.pins[static_cast<std::size_t>(thread_) % plan_.pins.size()], &set);
        pthread_setaffinity_np(pthread_self(), sizeof set, &set);
    }
    if (plan_.arrivals.kind != Arrivals::closed) {
        schedule_ = std::make_unique<Schedule>(plan_.arrivals, thread_, plan_.threads, random_());
        next_ = schedule_->next();
        return;
    }
    const int all = plan_.arrivals.concurrency;
    const int share = all / plan_.threads + (thread_ < all % plan_.threads ? 1 : 0);
    for (int i = 0; i < share; ++i) restarts_.push(start_);
}

void Generator::run(const std::atomic<bool>& stop) {
    if (!carrier_.ready()) return;
    prepare();
    while (step(stop.load(std::memory_order_relaxed))) {
    }
    readClocks(std::max(Clock::now(), measureTo_));
    if (clockFrom_ != TimePoint{}) series_.add(secondIndex_, second_);
    ended_.clear();
}

bool Generator::step(bool stopped) {
    // What comes after a shortage says nothing about the server, and may take long.
    stopped_ = stopped_ || stopped || carrier_.shortage().count > 0;
    TimePoint now = Clock::now();
    readClocks(now);
    rollSecond(now);
    const bool more = launchDue(now);
    runWakes(now);
    ended_.clear();
    if (!more && active_ == 0) return false;
    // What is under way after the end has the time that any request has.
    const auto patience = plan_.limits.timeout + 2s;
    if (now > measureTo_ + patience || (stopped_ && !more)) {
        giveUp();
        return false;
    }
    if (!carrier_.poll(std::min(nextDue(), now + 100ms)))
        spun_ += std::min<std::chrono::nanoseconds>(Clock::now() - now, kLongestSpin);
    return true;
}

TimePoint Generator::nextDue() const {
    TimePoint due = TimePoint::max();
    if (schedule_ && next_.at != kNever && !stopped_) due = start_ + next_.at;
    if (!restarts_.empty()) due = std::min(due, restarts_.top());
    if (!wakes_.empty()) due = std::min(due, wakes_.top().at);
    return due;
}

/// Sends what is due. @return whether there will be more
bool Generator::launchDue(TimePoint now) {
    const auto over = [&](TimePoint planned) {
        return stopped_ || planned >= measureTo_ ||
               launched_ * static_cast<std::uint64_t>(plan_.threads) >= plan_.maxRequests;
    };
    if (!schedule_) {
        if (over(now)) return false;
        for (int i = 0; i < kBurst && !restarts_.empty() && restarts_.top() <= now; ++i) {
            const TimePoint planned = restarts_.top();
            restarts_.pop();
            launch(planned, -1);
        }
        return true;
    }
    for (int i = 0; i < kBurst; ++i) {
        if (next_.at == kNever || over(start_ + next_.at)) return false;
        if (start_ + next_.at > now) return true;
        const Arrival due = next_;
        next_ = schedule_->next();
        launch(start_ + due.at, due.entry);
    }
    return true;
}

bool Generator::chance(double probability) {
    // Always drawn, so that one ratio does not shift the draws of the others.
    return std::uniform_real_distribution<double>(0, 1)(random_) < probability;
}

FlowDraw Generator::drawFlow(const MixEntry& entry) {
    const Mix& mix = plan_.mix.mix;
    FlowDraw draw;
    draw.duplicate = chance(mix.duplicates);
    draw.slow = chance(mix.slowClients);
    draw.verify = chance(plan_.verify) && !draw.slow;
    const double fate = std::uniform_real_distribution<double>(0, 1)(random_);
    draw.abandoned = entry.mode == Mode::job && fate < entry.abandoned;
    draw.cancelled =
        entry.mode == Mode::job && !draw.abandoned && fate < entry.abandoned + entry.cancelled;
    const bool aborts = chance(mix.aborts);
    std::uniform_int_distribution<std::int64_t> within(0, mix.abortAfter.count());
    const std::chrono::milliseconds delay(within(random_));
    if (aborts) draw.abortAfter = delay;
    return draw;
}

void Generator::launch(TimePoint planned, int entry) {
    ++launched_;
    if (entry < 0) entry = weights_(random_);
    const PreparedEntry& prepared = plan_.mix.entries[static_cast<std::size_t>(entry)];
    auto flow = makeFlow(*this, prepared, entry, drawFlow(prepared.entry));
    flow->planned = planned;
    flow->sentAt = Clock::now();
    flow->generation = ++generations_;
    if (flow->draw.slow) flow->bytesPerSecond = plan_.mix.mix.slowRate;
    if (freeSlots_.empty()) {
        freeSlots_.push_back(flows_.size());
        flows_.emplace_back();
    }
    flow->slot = freeSlots_.back();
    freeSlots_.pop_back();
    ++active_;
    Flow& started = *flow;
    flows_[flow->slot] = std::move(flow);
    started.start();
}

void Generator::send(Flow& flow) { carrier_.begin(flow); }
void Generator::breakOff(Flow& flow) { carrier_.abort(flow); }
void Generator::grown(Exchange& exchange) { static_cast<Flow&>(exchange).onGrown(); }
void Generator::ended(Exchange& exchange) { static_cast<Flow&>(exchange).onEnded(); }

void Generator::wake(Flow& flow, TimePoint at) { wakes_.push({at, flow.slot, flow.generation}); }

void Generator::runWakes(TimePoint now) {
    while (!wakes_.empty() && wakes_.top().at <= now) {
        const Wake due = wakes_.top();
        wakes_.pop();
        Flow* const flow = flows_[due.slot].get();
        if (flow != nullptr && flow->generation == due.generation) flow->woken();
    }
}

/// Nobody waits any longer: what is still under way has timed out.
void Generator::giveUp() {
    for (auto& flow : flows_) {
        if (!flow) continue;
        flow->ending = stopped_ ? Ending::aborted : Ending::failed;
        flow->error = stopped_ ? "" : nameOf(Fault::timeout);
        count(*flow);
    }
}

bool Generator::measured(const Flow& flow) const {
    return flow.planned >= measureFrom_ && flow.planned < measureTo_;
}

Tally& Generator::tally(const Flow& flow) { return measured(flow) ? tally_ : unmeasured_; }

void Generator::verify(const Flow& flow) {
    if (!measured(flow)) return;
    VerifySample sample;
    sample.entry = flow.entry;
    sample.same = flow.prepared.entry.mode != Mode::get;
    const std::string_view type = flow.answer.field("content-type");
    sample.type = type.substr(0, type.find(';'));
    sample.digest = flow.answer.field("content-digest");
    if (sample.digest.empty()) sample.digest = flow.answer.field("repr-digest");
    sample.body = const_cast<Flow&>(flow).answer.takeBody();
    verifier_.look(std::move(sample));
}

void Generator::finish(Flow& flow) {
    count(flow);
    if (!schedule_) {
        const bool unreachable = flow.ending == Ending::failed && neverConnected(flow.fault);
        restarts_.push(unreachable ? flow.ended + kReconnectPause : flow.ended);
    }
    --active_;
    freeSlots_.push_back(flow.slot);
    ended_.push_back(std::move(flows_[flow.slot]));
}

void Generator::count(const Flow& flow) {
    if (!measured(flow)) return;
    ++tally_.planned;
    ++tally_.entries[static_cast<std::size_t>(flow.entry)].planned;
    countSent(flow);
    if (flow.answer.status() != 0) ++tally_.statuses[flow.answer.status()];
    if (!flow.error.empty()) ++tally_.errors[flow.error];
    if (flow.retried) ++tally_.retried;
    if (flow.draw.slow) {
        ++tally_.slow;
        if (flow.ending == Ending::good)
            tally_[Measure::slow].record(microseconds(flow.sentAt, flow.ended));
        return;
    }
    switch (flow.ending) {
        case Ending::good: return countGood(flow);
        case Ending::refused:
            ++tally_.refused;
            ++second_.refused;
            tally_[Measure::refused].record(microseconds(flow.planned, flow.ended));
            return;
        case Ending::failed:
            ++tally_.failed;
            ++second_.failed;
            return;
        case Ending::aborted: ++tally_.aborted; return;
        case Ending::abandoned: ++tally_.abandoned; return;
        case Ending::cancelled: ++tally_.cancelled; return;
    }
}

void Generator::countSent(const Flow& flow) {
    if (flow.error == nameOf(Fault::notSent)) return;
    ++tally_.sent;
    ++second_.sent;
    tally_[Measure::lag].record(microseconds(flow.planned, flow.sentAt));
    if (schedule_ && flow.sentAt - flow.planned > lateLimit_) ++tally_.late;
}

void Generator::countGood(const Flow& flow) {
    const TimePoint end = flow.ended;
    const std::int64_t corrected = microseconds(flow.planned, end);
    const std::int64_t asSent = microseconds(flow.sentAt, end);
    EntryTally& entry = tally_.entries[static_cast<std::size_t>(flow.entry)];
    ++tally_.good;
    ++second_.good;
    ++entry.good;
    if (corrected <= plan_.sloLimit) {
        ++tally_.withinSlo;
        ++second_.withinSlo;
    }
    tally_[Measure::corrected].record(corrected);
    tally_[Measure::asSent].record(asSent);
    tally_[Measure::service].record(microseconds(flow.standing, end));
    entry.corrected.record(corrected);
    second_.corrected.emplace_back(Histogram::indexOf(corrected), 1);
    second_.asSent.emplace_back(Histogram::indexOf(asSent), 1);
}

/// Hands a second over when it is past.
void Generator::rollSecond(TimePoint now) {
    if (now < measureFrom_) {
        bytesBefore_ = carrier_.bytesIn();
        return;
    }
    const auto index = static_cast<std::size_t>(
        std::chrono::duration_cast<std::chrono::seconds>(now - measureFrom_).count());
    if (index == secondIndex_) return;
    second_.bytesIn = carrier_.bytesIn() - bytesBefore_;
    bytesBefore_ = carrier_.bytesIn();
    series_.add(secondIndex_, std::exchange(second_, {}));
    secondIndex_ = index;
}

/// Notes what the thread has used between the two ends of the measured time.
void Generator::readClocks(TimePoint now) {
    if (now < measureFrom_) return;
    if (clockFrom_ == TimePoint{}) {
        clockFrom_ = now;
        cpuBefore_ = threadTime();
        spun_ = {};
    }
    if (busy_ > 0 || now < measureTo_) return;
    const std::chrono::duration<double> used = threadTime() - cpuBefore_ - spun_;
    const std::chrono::duration<double> wall = Clock::now() - clockFrom_;
    busy_ = std::clamp(used / wall, 1e-6, 1.0);
}

}  // namespace rivage::client::load
