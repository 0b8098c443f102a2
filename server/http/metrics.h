#pragma once

#include <string>

#include "server/jobs/job_pool.h"

namespace rivage::server {

/// What /metrics answers: Prometheus text, version 0.0.4.
[[nodiscard]] std::string metricsText(const JobPool& pool);

}  // namespace rivage::server
