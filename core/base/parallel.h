#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "core/base/run_context.h"

namespace rivage::core {

/// Who works on a loop: so many threads, until `run` asks to stop if there is one.
struct Workers {
    int threads = 1;
    const RunContext* run = nullptr;  ///< outlives the loop, and whatever keeps the workers

    Workers(int threadCount) : threads(threadCount) {}  // NOLINT(google-explicit-constructor)
    Workers(const RunContext& context)                  // NOLINT(google-explicit-constructor)
        : threads(context.threads), run(&context) {}
    [[nodiscard]] bool stopped() const { return run != nullptr && run->stopped(); }
};

/// Calls `body(begin, end)` for blocks that partition [0, count). The blocks depend on `count` and
/// `blockSize` only, never on the thread count, so a body that writes only its own elements gives
/// the same bits for any number of threads. Polls once a block.
/// @return false if the workers were asked to stop; some blocks were then not run
bool parallelBlocks(std::size_t count, std::size_t blockSize, const Workers& workers,
                    const std::function<void(std::size_t begin, std::size_t end)>& body);

/// As `parallelBlocks`, one element at a time.
/// @return false if `run` asked to stop; some elements were then not visited
template <typename Body>
[[nodiscard]] bool parallelFor(std::size_t count, const RunContext& run, Body&& body,
                               std::size_t blockSize = 1024) {
    return parallelBlocks(count, blockSize, run, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(i);
    });
}

/// As `parallelFor` in this thread alone, in order: for loops whose steps build on each other.
/// @return false if the workers were asked to stop; the last elements were then not visited
template <typename Body>
bool serialFor(std::size_t count, const Workers& workers, Body&& body,
               std::size_t blockSize = 4096) {
    for (std::size_t begin = 0; begin < count; begin += blockSize) {
        if (workers.stopped()) return false;
        const std::size_t end = begin + blockSize < count ? begin + blockSize : count;
        for (std::size_t i = begin; i < end; ++i) body(i);
    }
    return !workers.stopped();
}

/// Sum of `term(begin, end)` over fixed blocks, added in the order of the blocks: the same bits
/// for any number of threads. Means nothing once the workers were asked to stop.
template <typename Value, typename Term>
[[nodiscard]] Value blockedSum(std::size_t count, const Workers& workers, Value zero, Term&& term,
                               std::size_t blockSize = 4096) {
    const std::size_t blocks = (count + blockSize - 1) / blockSize;
    std::vector<Value> partial(blocks, zero);
    parallelBlocks(count, blockSize, workers, [&](std::size_t begin, std::size_t end) {
        partial[begin / blockSize] = term(begin, end);
    });
    Value sum = zero;
    for (const Value& value : partial) sum = sum + value;
    return sum;
}

}  // namespace rivage::core
