#pragma once

#include <string>

#include "client/job_calls.h"

namespace rivage::client {

/// A conversion that succeeded.
struct Conversion {
    std::string job;
    proto::Json report;
};

/// Runs one conversion as a job: submits it, follows it, and fetches its result into `store`. A job
/// that the server took and then does not know any more is submitted once again. After a stop, the
/// job is cancelled at the server; whatever else goes wrong, the failure names it.
/// @errors  what Transport::send has; what the job's own problem means; cancelled
Outcome<Conversion> convertGrid(Transport& transport, const Upload& upload, const ByteStore& store,
                                const JobWatch& watch);

}  // namespace rivage::client
