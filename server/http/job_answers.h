#pragma once

#include <memory>

#include "server/http/exchange.h"
#include "server/jobs/job_pool.h"

namespace rivage::server {

/// The job that the path names, if it is the caller's. @errors notFound; expired
core::Result<std::shared_ptr<Job>> findJob(Exchange& exchange);

/// The job as JSON; as long as it has not ended, with when to come back.
void writeJob(Exchange& exchange, int status, const Job& job);

/// 202: the job goes on, and this is where.
void writeAccepted(Exchange& exchange, const Job& job);

/// The answer of a job that has ended: its result, or its problem.
/// @return the result, or null if the answer is a problem
ResultPtr writeOutcome(Exchange& exchange, Job& job);

/// The bytes of a result, without copying them.
void writeBytes(httplib::Response& response, const ResultPtr& result);

/// `queue;dur=0.1, parse;dur=12.3, ...`, milliseconds.
[[nodiscard]] std::string serverTiming(const JobTimes& times);

}  // namespace rivage::server
