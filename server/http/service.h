#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "proto/job.h"
#include "server/http/access.h"
#include "server/http/upload_budget.h"
#include "server/jobs/job_pool.h"
#include "server/net/net_stats.h"
#include "server/web/assets.h"

namespace rivage::server {

/// Scenes that the server hands out to try it with; `core::sampleScene` in production.
struct Samples {
    std::vector<std::string> names;
    std::function<core::Result<std::vector<std::byte>>(const std::string& name)> make;
};

/// What the handlers work with; it outlives the HTTP server.
struct Service {
    JobPool& pool;
    proto::ServiceLimits limits;
    Samples samples = {};
    std::span<const WebAsset> assets = {};  ///< the viewer
    std::shared_ptr<Access> access = {};    ///< null: everybody may call
    std::vector<std::string> corsOrigins = {};
    std::size_t longPolls = 64;  ///< waiting GETs at a time; more are answered at once
    UploadBudget uploads = {};
    std::function<std::string()> metrics = {};  ///< what /metrics answers; unset: nothing
    const NetStats* net = nullptr;              ///< of the connections; null: nobody counts them
    /// When the connection loop last showed that it lives; unset: always now.
    std::function<Clock::time_point()> loopBeat = {};
    std::atomic<std::uint64_t> rejectedQuota{0};
    std::atomic<std::size_t> waiting{0};
    std::size_t streams = 64;  ///< clients that follow events at a time; more are refused
    std::atomic<std::size_t> streaming{0};
    std::atomic<bool> stopping{false};  ///< long polls end now
    std::atomic<bool> unready{false};   ///< load balancers are to send no more
    std::uint32_t restarts = 0;         ///< of the serving process after crashes
    /// What reads its files again at SIGHUP, and keeps what it had if that fails.
    std::vector<std::function<core::Result<void>()>> onReload = {};
};

}  // namespace rivage::server
