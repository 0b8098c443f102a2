#include "server/http/trace.h"

#include <algorithm>

#include "server/net/canned.h"

namespace rivage::server {
namespace {

constexpr const char* kTrace = "trace";
constexpr std::size_t kLength = 55;  // "00-" 32 "-" 16 "-" 2

bool isHex(std::string_view text) {
    return std::all_of(text.begin(), text.end(),
                       [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

bool isId(std::string_view text) {
    return isHex(text) && text.find_first_not_of('0') != std::string_view::npos;
}

}  // namespace

std::string Trace::traceparent() const {
    return traceId.empty() ? std::string() : "00-" + traceId + "-" + spanId + "-" + flags;
}

std::optional<Trace> parseTraceparent(std::string_view text) {
    if (text.size() < kLength || text[2] != '-' || text[35] != '-' || text[52] != '-')
        return std::nullopt;
    const std::string_view version = text.substr(0, 2);
    const std::string_view flags = text.substr(53, 2);
    if (!isHex(version) || version == "ff" || !isHex(flags)) return std::nullopt;
    if (text.size() > kLength && (version == "00" || text[kLength] != '-')) return std::nullopt;
    if (!isId(text.substr(3, 32)) || !isId(text.substr(36, 16))) return std::nullopt;
    Trace trace;
    trace.traceId = text.substr(3, 32);
    trace.parentId = text.substr(36, 16);
    // Of the flags only "sampled" has a meaning that outlives versions.
    const char last = flags.back();
    const int bits = last <= '9' ? last - '0' : last - 'a' + 10;
    trace.flags = (bits & 1) != 0 ? "01" : "00";
    return trace;
}

const Trace& traceOf(const httplib::Request& request, httplib::Response& response) {
    if (const Trace* kept = response.user_data.get<Trace>(kTrace)) return *kept;
    std::optional<Trace> trace;
    if (request.get_header_value_count("traceparent") == 1)
        trace = parseTraceparent(request.get_header_value("traceparent"));
    if (!trace) trace = Trace{randomHex(16), {}, {}};
    trace->spanId = randomHex(8);
    response.user_data.set(kTrace, *std::move(trace));
    return *response.user_data.get<Trace>(kTrace);
}

const Trace& traceOf(const httplib::Response& response) {
    static const Trace kNone;
    const auto* kept = response.user_data.get<Trace>(kTrace);
    return kept ? *kept : kNone;
}

}  // namespace rivage::server
