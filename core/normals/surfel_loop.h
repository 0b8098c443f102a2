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
    constexpr std::size_t kPoll = 16;  // a surfel inside noise takes half a millisecond
    return parallelBlocks(surface.surfelCount(), kBlock, run,
                          [&](std::size_t begin, std::size_t end) {
                              PatchWalker walker(surface, links);
                              for (std::size_t i = begin; i < end; ++i) {
                                  if (i % kPoll == kPoll - 1 && run.stopped()) return;
                                  body(SurfelId{static_cast<std::uint32_t>(i)}, walker);
                              }
                          });
}

}  // namespace rivage::core
