#pragma once

#include "core/base/parallel.h"
#include "core/normals/patch_walker.h"

namespace rivage::core {

/// Calls `body(surfel, walker)` for every surfel, in parallel; a walker serves a block of surfels.
/// @return false if `run` asked to stop; some surfels were then not visited
template <typename Body>
[[nodiscard]] bool forEachSurfel(const DigitalSurface& surface, const SurfelLinks& links,
                                 const RunContext& run, Body&& body) {
    constexpr std::size_t kBlock = 512;
    parallelBlocks(surface.surfelCount(), kBlock, run.threads,
                   [&](std::size_t begin, std::size_t end) {
                       if (run.stopped()) return;
                       PatchWalker walker(surface, links);
                       for (std::size_t i = begin; i < end; ++i)
                           body(SurfelId{static_cast<std::uint32_t>(i)}, walker);
                   });
    return !run.stopped();
}

}  // namespace rivage::core
