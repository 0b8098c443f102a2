#pragma once

#include "server/http/service.h"
#include "server/jobs/job_pool.h"

namespace rivage::server {

/// The engine in production: `core::convert` and `core::inspect`.
[[nodiscard]] Engine coreEngine();

/// The samples in production: those of `core::sampleScene`.
[[nodiscard]] Samples coreSamples();

}  // namespace rivage::server
