#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "proto/job.h"

namespace rivage::server {

/// Everything about one job that outlives its process. Texts of JSON are kept as they were written;
/// the bytes of its grid and its result are blobs.
struct JobRecord {
    std::string id;
    std::string owner;  ///< name of the API key; empty without keys
    std::string idempotencyKey = {};
    std::string key = {};      ///< content + options + engine; see `JobRequest`
    std::string options = {};  ///< JSON, as `proto::toJson` echoes them
    std::string name = {};     ///< of the grid, without extension
    std::string requestId = {};
    std::string traceparent = {};
    std::string inputSha256 = {};  ///< hex; its blob is needed until the job has ended
    std::uint64_t inputBytes = 0;

    proto::JobState state = proto::JobState::queued;
    std::string stage = {};  ///< the one that it ended in; empty if none began
    int attempt = 0;
    proto::WallTime created = {};
    std::optional<proto::WallTime> started = {};
    std::optional<proto::WallTime> finished = {};
    std::optional<proto::WallTime> expires = {};

    std::string resultSha256 = {};  ///< hex; empty without a result
    std::uint64_t resultBytes = 0;
    std::string mediaType = {};
    std::string extension = {};
    std::string report = {};  ///< JSON; empty unless it succeeded
    std::optional<core::Error> error = {};
};

}  // namespace rivage::server
