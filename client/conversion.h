#pragma once

#include <functional>
#include <optional>
#include <string>

#include "client/transport.h"
#include "client/upload.h"

namespace rivage::client {

/// How far a job is.
struct JobProgress {
    std::string state;                    ///< of the wire: "queued", "running", ...
    std::string stage;                    ///< empty before the first
    double fraction = 0;                  ///< 0..1
    std::optional<double> queuePosition;  ///< 0 is next
};

struct ConversionWatch {
    std::function<void(const JobProgress&)> progress;
    bool lively = false;  ///< ask several times a second instead of waiting at the server
};

/// Runs one conversion as a job: submits it, follows it, and fetches its result into `sink`. A job
/// that is given up (a stop, the deadline) is cancelled at the server.
/// @return  the report
/// @errors  what Transport::send has; what the job's own problem means; cancelled
Outcome<proto::Json> convertGrid(Transport& transport, const Upload& upload, const BodySink& sink,
                                 const ConversionWatch& watch);

}  // namespace rivage::client
