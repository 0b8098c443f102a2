#pragma once

#include <string>
#include <vector>

#include "tests/study/samples.h"

/// What the study measures, section by section.
namespace rivage::study {

struct Effort {
    int poses = 8;
    int resolution = 32;  ///< of all sections but `convergence`
    int largest = 256;    ///< resolution of `convergence`
    int threads = 1;      ///< of the study; each run has one
    bool quick = false;   ///< three shapes, few levels: to see that all of it works
};

/// The sections in the order of the report.
[[nodiscard]] const std::vector<std::string>& sectionNames();

/// Runs a section; the same samples for any number of threads, but for their times.
[[nodiscard]] Samples runSection(const std::string& name, const Effort& scale);

/// Section `speed`: gradients and steps of the solvers on the sample `island`, whose 64 x 68 x 40
/// voxels are as many as those of the Lake of [CGL18]. `level` is the number of steps;
/// `normal_mean` and `rms` are against the minimum.
[[nodiscard]] Samples runSpeed();

}  // namespace rivage::study
