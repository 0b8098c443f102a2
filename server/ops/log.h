#pragma once

#include <string>

#include "proto/json.h"
#include "server/http/http_server.h"
#include "server/jobs/job.h"
#include "server/ops/settings.h"

namespace rivage::server {

/// Sends the log to stderr, one event a line: as text, or as one JSON object.
void setUpLog(LogFormat format, const std::string& level);

/// One event: what happened, and its facts in their order.
void logInfo(const std::string& event, const proto::Json& facts);
void logWarning(const std::string& event, const proto::Json& facts);

/// One line as it is written, without its end: text without time and level, which the log adds
/// itself, or JSON with them. No fact can begin another line or another fact.
[[nodiscard]] std::string logLine(LogFormat format, const std::string& level,
                                  const std::string& event, const proto::Json& facts);

/// What the line of a request says.
[[nodiscard]] proto::Json requestFacts(const RequestRecord& record);

/// The line of one request. Requests of a client that left count as 499.
void logRequest(const RequestRecord& record);

/// The line of one job that has ended.
void logJob(const JobFacts& facts, const JobSnapshot& job);

}  // namespace rivage::server
