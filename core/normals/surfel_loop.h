#pragma once

#include <atomic>
#include <mutex>

#include "core/base/parallel.h"
#include "core/normals/patch_walker.h"

namespace rivage::core {

/// How far the threads of a loop are. Whoever finds another one reporting goes on without.
class LoopProgress {
public:
    LoopProgress(std::size_t count, const RunContext& run) : count_(count), run_(run) {}
    void add(std::size_t done) {
        done_ += done;
        if (const std::unique_lock lock(reporting_, std::try_to_lock); lock)
            run_.report(Stage::normals, static_cast<double>(done_) / static_cast<double>(count_));
    }

private:
    std::size_t count_;
    const RunContext& run_;
    std::atomic<std::size_t> done_ = 0;
    std::mutex reporting_;
};

/// Calls `body(surfel, walker)` for every surfel, in parallel; a walker serves a block of surfels.
/// Reports from 0 to 1 of the normals: for one of several passes, `run` is that of its part.
/// @return false if `run` asked to stop; some surfels were then not visited
template <typename Body>
[[nodiscard]] bool forEachSurfel(const DigitalSurface& surface, const SurfelLinks& links,
                                 const RunContext& run, Body&& body) {
    constexpr std::size_t kBlock = 512;
    constexpr std::size_t kPoll = 16;  // a surfel inside noise takes half a millisecond
    LoopProgress progress(surface.surfelCount(), run);
    return parallelBlocks(surface.surfelCount(), kBlock, run,
                          [&](std::size_t begin, std::size_t end) {
                              PatchWalker walker(surface, links);
                              for (std::size_t i = begin; i < end; ++i) {
                                  if (i % kPoll == kPoll - 1 && run.stopped()) return;
                                  body(SurfelId{static_cast<std::uint32_t>(i)}, walker);
                              }
                              progress.add(end - begin);
                          });
}

}  // namespace rivage::core
