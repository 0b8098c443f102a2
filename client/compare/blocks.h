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
/// @param work  must not throw
template <typename Work>
void forBlocks(std::size_t count, unsigned threads, const Work& work) {
    constexpr std::size_t kBlock = 1024;
    std::atomic<std::size_t> next = 0;
    const auto run = [&] {
        for (std::size_t from = 0; (from = next.fetch_add(kBlock)) < count;)
            work(from, std::min(from + kBlock, count));
    };
    const std::size_t most = std::min<std::size_t>(threads, (count + kBlock - 1) / kBlock);
    std::vector<std::jthread> others;
    try {
        while (others.size() + 1 < most) others.emplace_back(run);
    } catch (const std::system_error&) {
        // The machine has no thread left; those that run do it all.
    }
    run();
}

}  // namespace rivage::client
