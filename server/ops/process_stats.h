#pragma once

#include <cstddef>

namespace rivage::server {

/// What the system says about this process, in the units of the `process_*` metrics.
struct ProcessStats {
    double cpuSeconds = 0;
    double startTimeSeconds = 0;  ///< since 1970
    double residentBytes = 0;
    double virtualBytes = 0;
    double threads = 0;
    double openFiles = 0;
    double maxFiles = 0;
};
[[nodiscard]] ProcessStats readProcessStats();

}  // namespace rivage::server
