#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/download.h"
#include "client/upload.h"

namespace rivage::client {

/// How far a job is.
struct JobProgress {
    std::string state;                    ///< of the wire: "queued", "running", ...
    std::string stage;                    ///< empty before the first
    double fraction = 0;                  ///< 0..1
    std::optional<double> queuePosition;  ///< 0 is next
    std::optional<double> energy;         ///< of the surface so far, while it is solved for
    std::optional<double> step;           ///< of the solver
};

[[nodiscard]] JobProgress progressOf(const proto::Json& job);

struct JobWatch {
    std::function<void(const JobProgress&)> progress;
    bool lively = false;  ///< ask several times a second instead of waiting at the server
};

/// Whether a text can be the id of a job: letters, digits, '-' and '_'.
[[nodiscard]] bool isJobId(const std::string& text);

/// Submits a grid; one Idempotency-Key for all tries, so that they make one job.
/// @return  the id of the job
Outcome<std::string> submitJob(Transport& transport, const Upload& upload);

/// The document of a job as it is now.
/// @errors  what Transport::send has; refused if there is no such job
Outcome<proto::Json> getJob(Transport& transport, const std::string& id);

/// Waits until a job has ended, however it did.
/// @return  its document
Outcome<proto::Json> followJob(Transport& transport, const std::string& id, const JobWatch& watch);

/// The report of a job that has ended.
/// @errors  cancelled; what the job's own problem means
Outcome<proto::Json> reportOf(const proto::Json& job);

/// Fetches the result of a job that succeeded.
Outcome<void> fetchResult(Transport& transport, const std::string& id, const ByteStore& store);

struct JobQuery {
    std::string state;       ///< empty: all
    std::size_t limit = 20;  ///< 0: all there are
};

/// The caller's jobs, newest first, from as many pages as it takes.
Outcome<std::vector<proto::Json>> listJobs(Transport& transport, const JobQuery& query);

/// The request that cancels a job, or forgets one that has ended.
[[nodiscard]] httplib::Request makeDeletion(const std::string& id);

}  // namespace rivage::client
