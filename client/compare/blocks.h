#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <system_error>
#include <thread>
#include <vector>

namespace rivage::client {

/// Calls `work(from, to)` for blocks that cover 0 to `count`, on several threads. Blocks are the
/// same for any number of threads, so results that go to their own place do not depend on it.
/// @param work   must not throw
/// @param block  calls of a block, for work that is worth more or less than a search
template <typename Work>
void forBlocks(std::size_t count, unsigned threads, const Work& work, std::size_t block = 1024) {
    std::atomic<std::size_t> next = 0;
    const auto run = [&] {
        for (std::size_t from = 0; (from = next.fetch_add(block)) < count;)
            work(from, std::min(from + block, count));
    };
    const std::size_t most = std::min<std::size_t>(threads, (count + block - 1) / block);
    std::vector<std::jthread> others;
    try {
        while (others.size() + 1 < most) others.emplace_back(run);
    } catch (const std::system_error&) {
        // The machine has no thread left; those that run do it all.
    }
    run();
}

}  // namespace rivage::client
