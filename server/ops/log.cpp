#include "server/ops/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <memory>

namespace rivage::server {
namespace {

LogFormat& format() {
    static LogFormat value = LogFormat::text;
    return value;
}

/// Bytes that could forge a line become '?'; a text with spaces is quoted.
std::string shown(const proto::Json& value) {
    if (!value.is_string()) return proto::writeJson(value);
    std::string text = value.get<std::string>();
    if (text.empty()) return "-";
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
    const bool plain = text.find_first_of(" =\"\\") == std::string::npos;
    return plain ? text : proto::writeJson(text);
}

void write(spdlog::level::level_enum level, const std::string& event, const proto::Json& facts) {
    if (!spdlog::should_log(level)) return;
    const auto name = spdlog::level::to_string_view(level);
    spdlog::log(level, "{}", logLine(format(), {name.data(), name.size()}, event, facts));
}

std::string traceIdOf(const std::string& traceparent) {
    return traceparent.size() > 35 ? traceparent.substr(3, 32) : std::string();
}

double rounded(double milliseconds) { return std::round(milliseconds * 1000) / 1000; }

}  // namespace

std::string logLine(LogFormat chosen, const std::string& level, const std::string& event,
                    const proto::Json& facts) {
    if (chosen == LogFormat::json) {
        proto::Json line{{"time", proto::timestamp(std::chrono::system_clock::now())},
                         {"level", level},
                         {"event", event}};
        line.update(facts);
        return proto::writeJson(line);
    }
    std::string line = event;
    for (const auto& [name, value] : facts.items()) line += " " + name + "=" + shown(value);
    return line;
}

void setUpLog(LogFormat chosen, const std::string& level) {
    format() = chosen;
    auto logger = std::make_shared<spdlog::logger>(
        "rivage", std::make_shared<spdlog::sinks::stderr_sink_mt>());
    logger->set_pattern(chosen == LogFormat::json ? "%v" : "%Y-%m-%dT%H:%M:%S.%eZ %l %v",
                        spdlog::pattern_time_type::utc);
    logger->set_level(spdlog::level::from_str(level));
    logger->flush_on(spdlog::level::warn);
    spdlog::set_default_logger(std::move(logger));
}

void logInfo(const std::string& event, const proto::Json& facts) {
    write(spdlog::level::info, event, facts);
}

void logWarning(const std::string& event, const proto::Json& facts) {
    write(spdlog::level::warn, event, facts);
}

proto::Json requestFacts(const RequestRecord& record) {
    proto::Json facts{{"id", record.id},
                      {"trace_id", record.traceId},
                      {"span", record.spanId},
                      {"parent_span", record.parentSpan},
                      {"caller", record.caller},
                      {"client", record.client},
                      {"method", record.method},
                      {"route", record.route},
                      {"status", record.status},
                      {"outcome", record.outcome},
                      {"ms", rounded(record.milliseconds)},
                      {"queue_ms", rounded(record.queueMs)},
                      {"compute_ms", rounded(record.computeMs)},
                      {"bytes_in", record.bytesIn},
                      {"bytes_out", record.bytes}};
    if (!record.job.empty()) facts["job"] = record.job;
    if (!record.problem.empty()) facts["problem"] = record.problem;
    return facts;
}

void logRequest(const RequestRecord& record) {
    const bool ours = record.outcome == "server_error" || record.outcome == "engine_error";
    write(ours ? spdlog::level::warn : spdlog::level::info, "request", requestFacts(record));
}

void logJob(const JobFacts& about, const JobSnapshot& job) {
    double milliseconds = 0;
    for (const double stage : job.times.stages) milliseconds += stage;
    proto::Json facts{{"job", job.view.id},
                      {"id", about.requestId},
                      {"trace_id", traceIdOf(about.traceparent)},
                      {"caller", about.owner},
                      {"state", proto::stateName(job.view.state)},
                      {"queue_ms", rounded(job.times.queue)},
                      {"ms", rounded(milliseconds)},
                      {"voxels", job.facts ? job.facts->voxels : 0},
                      {"surfels", job.facts ? job.facts->surfels : 0},
                      {"input_bytes", about.inputBytes},
                      {"bytes", job.result ? job.result->size() : 0}};
    if (job.error) facts["problem"] = proto::problemType(job.error->code).slug;
    const bool ours = job.error && job.error->code == core::ErrorCode::internal;
    if (ours) facts["detail"] = job.error->message;
    write(ours ? spdlog::level::err : spdlog::level::info, "job", facts);
}

}  // namespace rivage::server
