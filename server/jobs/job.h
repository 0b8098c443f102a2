#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/pipeline.h"
#include "proto/job.h"
#include "server/jobs/blob_store.h"
#include "server/jobs/job_record.h"

namespace rivage::server {

using Clock = std::chrono::steady_clock;

enum class JobKind : std::uint8_t {
    convert,  ///< grid to asset
    inspect,  ///< grid to what is in it; not listed, not kept
};

/// How a job came to its outcome.
enum class Reuse : std::uint8_t {
    none,       ///< it was run for this job
    collapsed,  ///< it was run once for several identical jobs
    hit,        ///< an earlier job's result was still there
    bypass,     ///< it was run because the client wanted no kept result
};

/// What does not change about a job from its acceptance on.
struct JobFacts {
    std::string id = {};
    JobKind kind = JobKind::convert;
    std::string owner = {};           ///< name of the API key; empty without keys
    std::string idempotencyKey = {};  ///< or empty
    std::string key = {};         ///< of content, options, engine and owner: same key, same result
    std::string options = {};     ///< JSON, as they are echoed
    bool progressive = false;     ///< previews are wanted
    std::string name = "rivage";  ///< of the grid, without extension; safe in a header
    std::string requestId = {};
    std::string traceparent = {};
    std::string inputSha256 = {};  ///< hex
    std::uint64_t inputBytes = 0;
    proto::WallTime created = std::chrono::system_clock::now();
};

/// The bytes that a run made; they never change, and identical jobs share them.
struct JobResult {
    BlobPtr blob;
    std::string mediaType;
    std::string extension;
    std::string etag;        ///< strong, quoted: the same bytes have the same one everywhere
    std::string reprDigest;  ///< RFC 9530

    JobResult(BlobPtr bytes, std::string type, std::string suffix);
    [[nodiscard]] std::size_t size() const { return blob->bytes().size(); }
};
using ResultPtr = std::shared_ptr<const JobResult>;

/// Milliseconds that a job has spent.
struct JobTimes {
    double queue = 0;
    std::array<double, core::kStageCount> stages{};
};

/// What a run has found out, beside its result.
struct RunFacts {
    std::string report = {};  ///< JSON; empty if it failed
    std::array<double, core::kStageCount> stages{};
    std::uint64_t voxels = 0;
    std::uint64_t surfels = 0;
    std::uint64_t triangles = 0;
    std::uint64_t iterations = 0;
};

/// How a run, and so every job that it was for, has ended: with a result or an error.
struct RunOutcome {
    ResultPtr result = {};
    std::optional<core::Error> error = {};
    std::shared_ptr<const RunFacts> facts = {};
};

/// An intermediate surface of a job that runs.
struct JobPreview {
    int step = 0;
    double energy = 0;
    ResultPtr surface = {};
};

/// Something that happened to a job, as `GET /v1/jobs/{id}/events` sends it.
struct JobEvent {
    std::uint64_t id = 0;
    std::string name = {};
    std::string data = {};  ///< JSON in one line
};

/// What a job is at one moment. `view` lacks its place in the queue, its options and its report.
struct JobSnapshot {
    proto::JobView view;
    std::optional<core::Error> error = {};
    ResultPtr result = {};
    JobTimes times = {};
    std::shared_ptr<const RunFacts> facts = {};
    Reuse reuse = Reuse::none;
};

/// One job and its states: queued -> running -> succeeded, failed or canceled. The first end counts
/// and is the only one. Safe to use from several threads.
class Job {
public:
    /// @param deadline  when it must have ended
    Job(JobFacts facts, Clock::time_point deadline);
    /// A job of an earlier process; one that had not ended is queued again.
    Job(const JobRecord& record, Clock::time_point deadline);

    [[nodiscard]] const JobFacts& facts() const { return facts_; }
    [[nodiscard]] const std::string& id() const { return facts_.id; }
    [[nodiscard]] Clock::time_point deadline() const { return deadline_; }

    /// Its run begins. @return false if it has ended already
    bool start();
    /// Its run is in a stage, and has done this share of all its work; never falls.
    void advance(core::Stage stage, double progress);
    /// Where its solver is.
    void advance(proto::SolverStep solver);
    /// So many others are before it; told to those who follow its events.
    void advanceInQueue(std::size_t position);
    void offer(JobPreview preview);
    [[nodiscard]] std::optional<JobPreview> preview() const;

    /// Ends it.
    /// @param kept  for how long it is known from now on; 0: `setExpiry` will say it
    /// @return false if it had ended before: then nothing changes
    bool end(const RunOutcome& outcome, std::chrono::seconds kept = std::chrono::seconds(0));
    /// How it comes to its outcome, as is known when it is accepted.
    void setReuse(Reuse reuse);
    /// Wakes those that wait for the end, once all bookkeeping is done.
    void announce();

    /// Waits until the end was announced or `timeout` is over. @return whether it was announced
    [[nodiscard]] bool waitEnded(std::chrono::milliseconds timeout) const;
    /// Events later than `after`; waits for one until `timeout` is over or the end was announced.
    [[nodiscard]] std::vector<JobEvent> waitEvents(std::uint64_t after,
                                                   std::chrono::milliseconds timeout) const;
    [[nodiscard]] bool announced() const;

    [[nodiscard]] proto::JobState state() const;
    [[nodiscard]] JobSnapshot snapshot() const;
    /// With options and report; without its place in the queue.
    [[nodiscard]] proto::JobView view() const;
    [[nodiscard]] JobRecord record() const;

    /// The client was promised an answer later: nobody's leaving cancels it any more.
    void makeDurable();
    [[nodiscard]] bool durable() const;
    /// A client waits for the answer. Each `addWaiter` is followed by one `removeWaiter`.
    void addWaiter();
    /// @return whether nobody is left who wants the job
    [[nodiscard]] bool removeWaiter();

    /// The bytes of a result that an earlier process has made.
    void restoreResult(ResultPtr result);
    /// The bytes are given up, because their time is over or others need the room.
    void dropResult();
    /// When an ended job is to be forgotten; set by whoever keeps it.
    void setExpiry(proto::WallTime expiry);

private:
    void addEvent(const char* name, const proto::Json& data);
    void addProgressEvent(std::optional<std::size_t> position = std::nullopt);
    [[nodiscard]] bool ended() const { return proto::hasEnded(now_.view.state); }

    const JobFacts facts_;
    const Clock::time_point created_ = Clock::now();
    const Clock::time_point deadline_;

    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
    bool announced_ = false;
    bool durable_ = false;
    int waiters_ = 0;
    JobSnapshot now_;
    std::string resultSha256_;  ///< also while the bytes are not loaded
    std::uint64_t resultBytes_ = 0;
    std::string mediaType_;
    std::string extension_;
    std::optional<JobPreview> preview_;
    std::deque<JobEvent> events_;
    std::uint64_t lastEvent_ = 0;
    Clock::time_point lastProgress_;
};

}  // namespace rivage::server
