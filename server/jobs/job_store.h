#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/jobs/job_record.h"

namespace rivage::server {

/// Where jobs outlive the process: their records, each written as a whole. Safe to call from
/// several threads.
class JobStore {
public:
    virtual ~JobStore() = default;
    /// Writes a record, over an older one of the same id. It is durable on return.
    /// @errors storageFull; internal
    virtual core::Result<void> save(const JobRecord& record) = 0;
    virtual core::Result<void> erase(std::span<const std::string> ids) = 0;
    /// All records, the oldest first. @errors internal
    virtual core::Result<std::vector<JobRecord>> load() = 0;
};

}  // namespace rivage::server
