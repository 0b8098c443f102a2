#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "core/base/run_context.h"

namespace rivage::core {

/// Calls `body(begin, end)` for blocks that partition [0, count). The blocks depend on `count` and
/// `blockSize` only, never on the thread count, so a body that writes only its own elements gives
/// the same bits for any number of threads.
/// @return false if `run` asked to stop; some blocks were then not run
void parallelBlocks(std::size_t count, std::size_t blockSize, int threads,
                    const std::function<void(std::size_t begin, std::size_t end)>& body);

/// As `parallelBlocks`, one element at a time; polls `run` once a block.
/// @return false if `run` asked to stop; some elements were then not visited
template <typename Body>
[[nodiscard]] bool parallelFor(std::size_t count, const RunContext& run, Body&& body,
                               std::size_t blockSize = 1024) {
    parallelBlocks(count, blockSize, run.threads, [&](std::size_t begin, std::size_t end) {
        if (run.stopped()) return;
        for (std::size_t i = begin; i < end; ++i) body(i);
    });
    return !run.stopped();
}

/// Sum of `term(begin, end)` over fixed blocks, added in the order of the blocks: the same bits
/// for any number of threads.
template <typename Value, typename Term>
[[nodiscard]] Value blockedSum(std::size_t count, int threads, Value zero, Term&& term,
                               std::size_t blockSize = 4096) {
    const std::size_t blocks = (count + blockSize - 1) / blockSize;
    std::vector<Value> partial(blocks, zero);
    parallelBlocks(count, blockSize, threads, [&](std::size_t begin, std::size_t end) {
        partial[begin / blockSize] = term(begin, end);
    });
    Value sum = zero;
    for (const Value& value : partial) sum = sum + value;
    return sum;
}

}  // namespace rivage::core
