#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "client/load/exchange.h"
#include "client/load/requests.h"
#include "client/load/tally.h"
#include "proto/json.h"

namespace rivage::client::load {

enum class Ending : std::uint8_t { good, refused, failed, aborted, abandoned, cancelled };

/// What chance decided about one planned request.
struct FlowDraw {
    bool duplicate = false;  ///< a kept result is welcome
    bool slow = false;
    bool verify = false;
    bool abandoned = false;
    bool cancelled = false;
    std::optional<std::chrono::milliseconds> abortAfter = {};
};

class Flow;

/// What carries the exchanges of flows.
class FlowHost {
public:
    virtual ~FlowHost() = default;
    /// Begins the exchange that the flow has filled in.
    virtual void send(Flow& flow) = 0;
    virtual void breakOff(Flow& flow) = 0;
    /// Calls `Flow::woken` at a time.
    virtual void wake(Flow& flow, TimePoint at) = 0;
    /// The flow has set its ending; it is gone soon.
    virtual void finish(Flow& flow) = 0;
    virtual const HeadWriter& heads() = 0;
    /// Where measures go; those of the warm-up go nowhere that is looked at.
    virtual Tally& tally(const Flow& flow) = 0;
    virtual void verify(const Flow& flow) = 0;
};

/// What becomes of one planned request: one exchange, or the several ones of a job.
class Flow : public Exchange {
public:
    Flow(FlowHost& flowHost, const PreparedEntry& what, int index, const FlowDraw& chance);
    ~Flow() override = default;
    Flow(const Flow&) = delete;
    Flow& operator=(const Flow&) = delete;

    virtual void start();
    virtual void onGrown() {}
    virtual void onEnded() = 0;
    virtual void woken();

    FlowHost& host;
    const PreparedEntry& prepared;
    const int entry;  ///< its index
    const FlowDraw draw;
    TimePoint planned;
    TimePoint sentAt;              ///< of the first exchange
    TimePoint standing;            ///< when its connection stood
    std::size_t slot = 0;          ///< of the host
    std::uint64_t generation = 0;  ///< of the host: which flow has the slot
    Ending ending = Ending::failed;
    std::string error;  ///< its class; empty if there is none

protected:
    void sendFirst();
    /// Sets the ending by what the exchange came to, if it is not a good answer.
    bool endedBadly();
    void finish(Ending how, std::string errorName = {});
    void measurePhases();
    void measureServer();
};

/// One exchange: a conversion in one request, or a plain GET.
class SingleFlow : public Flow {
public:
    using Flow::Flow;
    void onEnded() override;
};

/// A job: submitted, followed, and its result fetched; or left alone, or cancelled.
class JobFlow : public Flow {
public:
    using Flow::Flow;
    void onGrown() override;
    void onEnded() override;
    void woken() override;

private:
    enum class Step : std::uint8_t { submit, events, state, pause, result, cancel, settle };
    void request(Step step, std::string_view method, const std::string& path,
                 std::string_view fields = {});
    void accepted();
    void follow();
    void stateKnown(const proto::Json& job);
    void readState();
    void readEvents();
    void beginCancel();
    void cancelSettled();

    Step step_ = Step::submit;
    std::string job_;   ///< "/v1/jobs/..."
    std::string head_;  ///< of the request under way
    TimePoint cancelAt_;
    bool cancelling_ = false;
    bool eventSeen_ = false;
};

/// The flow that an entry asks for.
[[nodiscard]] std::unique_ptr<Flow> makeFlow(FlowHost& host, const PreparedEntry& prepared,
                                             int index, const FlowDraw& draw);

/// Microseconds between two times, at least 0.
[[nodiscard]] std::int64_t microseconds(TimePoint from, TimePoint to);

}  // namespace rivage::client::load
