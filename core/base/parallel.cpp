#include "core/base/parallel.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <algorithm>
#include <atomic>
#include <thread>

namespace rivage::core {
namespace {

#ifdef __SANITIZE_THREAD__
// oneTBB is not instrumented, so ThreadSanitizer would take its hand-overs for races: plain threads
// show it those of the stages alone.
template <typename RunBlock>
void runOnThreads(std::size_t blocks, int threads, const RunBlock& runBlock) {
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
        for (std::size_t block = next++; block < blocks; block = next++) runBlock(block);
    };
    std::vector<std::jthread> others;
    for (int i = 1; i < threads; ++i) others.emplace_back(work);
    work();
}
#else
template <typename RunBlock>
void runOnThreads(std::size_t blocks, int threads, const RunBlock& runBlock) {
    // More threads than the process allows would only make the library warn on stderr.
    const auto allowed =
        tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    tbb::task_arena arena(static_cast<int>(std::min<std::size_t>(threads, allowed)));
    arena.execute([&] {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks, 1),
                          [&](const tbb::blocked_range<std::size_t>& range) {
                              for (std::size_t b = range.begin(); b != range.end(); ++b)
                                  runBlock(b);
                          });
    });
}
#endif

}  // namespace

bool parallelBlocks(std::size_t count, std::size_t blockSize, const Workers& workers,
                    const std::function<void(std::size_t, std::size_t)>& body) {
    const std::size_t blocks = (count + blockSize - 1) / blockSize;
    const auto runBlock = [&](std::size_t block) {
        if (workers.stopped()) return;
        body(block * blockSize, std::min(count, (block + 1) * blockSize));
    };
    if (workers.threads <= 1 || blocks <= 1) {
        for (std::size_t block = 0; block < blocks; ++block) runBlock(block);
    } else {
        runOnThreads(blocks, workers.threads, runBlock);
    }
    return !workers.stopped();
}

}  // namespace rivage::core
