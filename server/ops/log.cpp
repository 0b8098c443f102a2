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
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    return text.find(' ') == std::string::npos ? text : '"' + text + '"';
}

void write(spdlog::level::level_enum level, const std::string& event, const proto::Json& facts) {
    if (!spdlog::should_log(level)) return;
    if (format() == LogFormat::json) {
        const auto name = spdlog::level::to_string_view(level);
        proto::Json line{{"time", proto::timestamp(std::chrono::system_clock::now())},
                         {"level", std::string(name.data(), name.size())},
                         {"event", event}};
        line.update(facts);
        spdlog::log(level, "{}", proto::writeJson(line));
        return;
    }
    std::string line = event;
    for (const auto& [name, value] : facts.items()) line += " " + name + "=" + shown(value);
    spdlog::log(level, "{}", line);
}

double rounded(double milliseconds) { return std::round(milliseconds * 1000) / 1000; }

}  // namespace

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

void logRequest(const RequestRecord& record) {
    proto::Json facts{{"id", record.id},
                      {"method", record.method},
                      {"route", record.route},
                      {"status", record.status},
                      {"ms", rounded(record.milliseconds)},
                      {"bytes", record.bytes}};
    if (!record.job.empty()) facts["job"] = record.job;
    write(record.status >= 500 ? spdlog::level::warn : spdlog::level::info, "request", facts);
}

void logJob(const JobFacts& about, const JobSnapshot& job) {
    double milliseconds = 0;
    for (const double stage : job.times.stages) milliseconds += stage;
    proto::Json facts{{"job", job.view.id},
                      {"id", about.requestId},
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
