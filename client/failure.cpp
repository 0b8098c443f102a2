#include "client/failure.h"

#include <algorithm>
#include <utility>

#include "client/printable.h"

namespace rivage::client {
namespace {

using proto::Json;

/// What an HTTP status means to whoever ran the command.
ExitCode exitOf(int status) {
    switch (status) {
        case 408:
        case 429:
        case 503:
        case 504: return ExitCode::busy;
        case 409: return ExitCode::cancelled;
        case 502: return ExitCode::unreachable;
        default: return status >= 400 && status < 500 ? ExitCode::refused : ExitCode::failed;
    }
}

}  // namespace

Failure failureWith(ExitCode exit, std::string title, std::string detail) {
    Json problem{{"title", std::move(title)}};
    if (!detail.empty()) problem["detail"] = std::move(detail);
    return {.exit = exit, .problem = std::move(problem)};
}

tl::unexpected<Failure> fail(ExitCode exit, std::string title, std::string detail) {
    return tl::unexpected(failureWith(exit, std::move(title), std::move(detail)));
}

Json readAnswer(std::string_view body) {
    constexpr proto::JsonLimits kLimits{
        .maxBytes = std::size_t{64} << 20, .maxDepth = 64, .maxMembers = 10'000};
    auto answer = proto::readJson(body, {}, kLimits);
    return answer && answer->is_object() ? *std::move(answer) : Json();
}

Failure failureOf(int status, std::string_view body) {
    Json problem = readAnswer(body);
    if (textOf(problem, "title").empty())
        problem = Json{{"title", "The server answered " + std::to_string(status)}};
    return {.exit = exitOf(status), .problem = std::move(problem)};
}

Failure failureOf(const Json& problem) {
    const int status = static_cast<int>(std::clamp(numberOf(problem, "status", 500), 0.0, 999.0));
    return failureOf(status, proto::writeJson(problem));
}

std::string describe(const Failure& failure) {
    const Json& problem = failure.problem;
    std::string text = textOf(problem, "title");
    const std::string detail = textOf(problem, "detail");
    if (!detail.empty()) text += ": " + detail;
    text = printable(text);
    for (const char* name : {"field", "limit", "actual", "setting"}) {
        const auto member = problem.find(name);
        if (member == problem.end()) continue;
        const std::string value =
            member->is_string() ? member->get<std::string>() : proto::writeJson(*member);
        text += std::string("\n  ") + name + ": " + printable(value);
    }
    return text;
}

std::string textOf(const Json& object, const char* name) {
    const auto member = object.find(name);
    return member != object.end() && member->is_string() ? member->get<std::string>()
                                                         : std::string();
}

double numberOf(const Json& object, const char* name, double otherwise) {
    const auto member = object.find(name);
    return member != object.end() && member->is_number() ? member->get<double>() : otherwise;
}

}  // namespace rivage::client
