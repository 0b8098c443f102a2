#include "client/load/taxonomy.h"

#include <algorithm>
#include <utility>

namespace rivage::client::load {

const char* nameOf(Fault fault) {
    switch (fault) {
        case Fault::none: return "";
        case Fault::notSent: return "not-sent";
        case Fault::connectRefused: return "connect-refused";
        case Fault::connectTimeout: return "connect-timeout";
        case Fault::connectFailed: return "connect-failed";
        case Fault::tlsFailed: return "tls-failed";
        case Fault::resetBeforeResponse: return "reset-before-response";
        case Fault::resetMidBody: return "reset-mid-body";
        case Fault::shortBody: return "short-body";
        case Fault::timeout: return "timeout";
        case Fault::malformed: return "malformed-answer";
        case Fault::aborted: return "aborted";
    }
    return "";
}

proto::Json readAnswer(std::string_view text, std::size_t maxBytes) {
    auto json = proto::readJson(text, "", {.maxBytes = maxBytes, .maxMembers = 1000});
    return json && json->is_object() ? *std::move(json) : proto::Json();
}

std::string problemSlug(std::string_view body) { return slugOf(readAnswer(body)); }

std::string slugOf(const proto::Json& problem) {
    if (!problem.is_object() || !problem.contains("type") || !problem["type"].is_string())
        return {};
    std::string slug = problem["type"].get<std::string>();
    slug.erase(0, slug.rfind('/') + 1);
    // It becomes a word of tables: a server that sends something else is quoted no further.
    const bool plain = std::all_of(slug.begin(), slug.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    });
    return plain && slug.size() <= 64 ? slug : std::string();
}

std::string errorClass(const Exchange& exchange) {
    if (exchange.fault != Fault::none) return nameOf(exchange.fault);
    const int status = exchange.answer.status();
    if (status >= 200 && status < 300) return {};
    if (status < 400) return "unexpected " + std::to_string(status);
    const std::string slug = problemSlug(exchange.answer.body());
    const std::string name = status == 503 ? "503-shed" : std::to_string(status);
    return slug.empty() ? name : name + " " + slug;
}

bool isRefusal(const Exchange& exchange) {
    const int status = exchange.answer.status();
    return exchange.fault == Fault::none && (status == 429 || status == 503);
}

}  // namespace rivage::client::load
