#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "core/base/report.h"
#include "core/base/run_context.h"
#include "proto/json.h"
#include "proto/problem.h"

namespace rivage::proto {

enum class JobState : std::uint8_t { queued, running, succeeded, failed, canceled };
[[nodiscard]] const char* stateName(JobState state);
[[nodiscard]] std::optional<JobState> stateFromName(std::string_view name);
[[nodiscard]] constexpr bool hasEnded(JobState state) { return state >= JobState::succeeded; }

using WallTime = std::chrono::system_clock::time_point;

/// Where the solver of a running job was when it last told.
struct SolverStep {
    int step = 0;
    double energy = 0;
};

/// A job as GET /v1/jobs/{id} shows it.
struct JobView {
    std::string id;
    std::string name = {};  ///< of the grid's file, without extension; safe in a header
    JobState state = JobState::queued;
    std::optional<core::Stage> stage = {};          ///< the one that runs, or that it ended in
    double progress = 0;                            ///< 0..1, never falls
    std::optional<SolverStep> solver = {};          ///< shown while it runs
    std::optional<std::size_t> queuePosition = {};  ///< 0 is next
    int attempt = 0;                                ///< how often it was started
    WallTime created = {};
    std::optional<WallTime> started = {};
    std::optional<WallTime> finished = {};
    std::optional<WallTime> expiresAt = {};
    Json options = Json::object();
    Json report;  ///< null until it succeeded
    std::optional<Problem> error = {};
    bool hasResult = false;  ///< the bytes are still there
};

[[nodiscard]] Json toJson(const JobView& job);

/// How far a job is, as its events tell it.
[[nodiscard]] Json progressJson(const JobView& job);

/// A point in time as RFC 3339 writes it, in UTC with milliseconds.
[[nodiscard]] std::string timestamp(WallTime time);

/// What the server bounds, beside the limits of one conversion.
struct ServiceLimits {
    core::Limits conversion = {};
    std::uint64_t maxUploadBytes = 0;
    std::size_t workers = 0;
    std::size_t queueLimit = 0;
    std::chrono::milliseconds deadline{};
    std::chrono::seconds resultTtl{};
    std::uint64_t keptResultBytes = 0;
    std::size_t keptJobs = 0;
    std::uint64_t uploadBudget = 0;  ///< bytes, of all uploads in flight together
    std::size_t streams = 0;         ///< event streams at a time
    std::size_t longPolls = 0;       ///< waiting GETs at a time
    std::chrono::seconds bodyTimeout{};
    std::uint64_t minBodyRate = 0;  ///< bytes per second, on average
    std::chrono::seconds idleTimeout{};
};

/// The answer of GET /v1/limits: each limit with its unit in its name.
[[nodiscard]] Json toJson(const ServiceLimits& limits);

/// The answer of GET /v1/formats: what is read and what is written.
[[nodiscard]] Json describeFormats();

}  // namespace rivage::proto
