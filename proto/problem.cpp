#include "proto/problem.h"

#include <array>

namespace rivage::proto {
namespace {

using core::ErrorCode;

constexpr std::array kCodes{
    ErrorCode::malformedInput, ErrorCode::unsupportedFormat, ErrorCode::tooLarge,
    ErrorCode::emptyGrid,      ErrorCode::tooManyLabels,     ErrorCode::memoryBudget,
    ErrorCode::unknownOption,  ErrorCode::invalidOption,     ErrorCode::malformedRequest,
    ErrorCode::notFound,       ErrorCode::methodNotAllowed,  ErrorCode::expired,
    ErrorCode::busy,           ErrorCode::draining,          ErrorCode::cancelled,
    ErrorCode::timedOut,       ErrorCode::notConverged,      ErrorCode::outputTooLarge,
    ErrorCode::unauthorized,   ErrorCode::forbidden,         ErrorCode::quotaExceeded,
    ErrorCode::digestMismatch, ErrorCode::keyReused,         ErrorCode::keyInProgress,
    ErrorCode::poison,         ErrorCode::storageFull,       ErrorCode::internal,
};

/// Statuses for which no error code exists, because no code of ours is reached.
constexpr std::array<ProblemType, 7> kTransport{{
    {400, "malformed-request", "The request is malformed"},
    {408, "request-timeout", "The request came too slowly"},
    {414, "uri-too-long", "The request target is too long"},
    {415, "unsupported-encoding", "The content encoding is not supported"},
    {416, "range-not-satisfiable", "The range does not lie in the result"},
    {417, "expectation-failed", "The expectation cannot be met"},
    {431, "headers-too-large", "The request header fields are too large"},
}};

}  // namespace

ProblemType problemType(ErrorCode code) {
    switch (code) {
        case ErrorCode::malformedInput:
            return {400, "malformed-input", "The grid breaks its own format"};
        case ErrorCode::unsupportedFormat:
            return {415, "unsupported-format", "The format of the grid is not supported"};
        case ErrorCode::tooLarge: return {413, "too-large", "The grid is too large"};
        case ErrorCode::emptyGrid: return {422, "empty-grid", "The grid has no voxel"};
        case ErrorCode::tooManyLabels:
            return {422, "too-many-labels", "The grid has too many labels"};
        case ErrorCode::memoryBudget:
            return {422, "memory-budget", "The conversion would need too much memory"};
        case ErrorCode::unknownOption: return {400, "unknown-option", "There is no such option"};
        case ErrorCode::invalidOption: return {400, "invalid-option", "An option is not valid"};
        case ErrorCode::malformedRequest:
            return {400, "malformed-request", "The request is malformed"};
        case ErrorCode::notFound: return {404, "not-found", "There is nothing here"};
        case ErrorCode::methodNotAllowed:
            return {405, "method-not-allowed", "The method is not allowed here"};
        case ErrorCode::expired: return {410, "result-expired", "The result has expired"};
        case ErrorCode::busy: return {503, "queue-full", "The server is full"};
        case ErrorCode::draining: return {503, "draining", "The server is stopping"};
        case ErrorCode::cancelled: return {409, "canceled", "The job was canceled"};
        case ErrorCode::timedOut: return {504, "deadline-exceeded", "The deadline passed"};
        case ErrorCode::notConverged:
            return {422, "not-converged", "The solver did not reach its tolerance"};
        case ErrorCode::outputTooLarge:
            return {422, "output-too-large", "The result does not fit its format"};
        case ErrorCode::unauthorized: return {401, "unauthorized", "A valid API key is needed"};
        case ErrorCode::forbidden: return {403, "forbidden", "The API key may not do this"};
        case ErrorCode::quotaExceeded:
            return {429, "quota-exceeded", "The quota of the API key is used up"};
        case ErrorCode::digestMismatch:
            return {400, "digest-mismatch", "The body does not have the digest that came with it"};
        case ErrorCode::keyReused:
            return {422, "idempotency-mismatch", "The idempotency key belongs to another request"};
        case ErrorCode::keyInProgress:
            return {409, "idempotency-in-progress",
                    "The request with this idempotency key is still being received"};
        case ErrorCode::poison:
            return {422, "poison", "The grid is in quarantine: it was running at two crashes"};
        case ErrorCode::storageFull:
            return {507, "storage-full", "The server has no room to keep jobs and results"};
        case ErrorCode::internal: return {500, "internal", "The server failed"};
    }
    return {500, "internal", "The server failed"};
}

ProblemType transportProblemType(int status) {
    for (const ProblemType& type : kTransport)
        if (type.status == status) return type;
    for (const ErrorCode code : kCodes)
        if (const ProblemType type = problemType(code); type.status == status) return type;
    return problemType(status < 500 ? ErrorCode::malformedRequest : ErrorCode::internal);
}

Problem makeProblem(const core::Error& error) {
    return {problemType(error.code),
            error.message,
            error.field,
            error.limit,
            error.actual,
            error.setting};
}

Json toJson(const Problem& problem) {
    Json json{{"type", "/problems/" + std::string(problem.type.slug)},
              {"title", problem.type.title},
              {"status", problem.type.status}};
    if (!problem.detail.empty()) json["detail"] = problem.detail;
    if (!problem.instance.empty()) json["instance"] = problem.instance;
    if (!problem.field.empty()) json["field"] = problem.field;
    if (problem.limit) json["limit"] = *problem.limit;
    if (problem.actual) json["actual"] = *problem.actual;
    if (!problem.setting.empty()) json["setting"] = problem.setting;
    return json;
}

std::vector<ProblemType> problemCatalogue() {
    std::vector<ProblemType> catalogue;
    catalogue.reserve(std::size(kCodes) + std::size(kTransport));
    for (const ErrorCode code : kCodes) catalogue.push_back(problemType(code));
    for (const ProblemType& type : kTransport)
        if (type.slug != "malformed-request") catalogue.push_back(type);
    return catalogue;
}

}  // namespace rivage::proto
