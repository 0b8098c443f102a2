#pragma once

#include "core/base/parallel.h"
#include "core/energy/lanes.h"

namespace rivage::core {

inline constexpr std::size_t kFloatBlock = 2048;  // pointels

/// Calls `body(i)` for each pointel, in parallel; one writer per element.
template <typename Body>
void forEachLanes(std::size_t size, const Workers& workers, Body&& body) {
    parallelBlocks(size, kFloatBlock, workers, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(i);
    });
}

/// Sum of the three lanes of `term(i)`: in float over a few pointels, from there in double; the
/// same bits for any number of threads.
template <typename Term>
[[nodiscard]] double sumLanes(std::size_t size, const Workers& workers, Term&& term) {
    constexpr std::size_t kRun = 16;
    return blockedSum(
        size, workers, 0.0,
        [&](std::size_t begin, std::size_t end) {
            double sum = 0;
            for (std::size_t i = begin; i < end;) {
                Lanes partial{};
                for (const std::size_t stop = std::min(end, i + kRun); i < stop; ++i)
                    partial += term(i);
                sum += double{partial[0]} + double{partial[1]} + double{partial[2]};
            }
            return sum;
        },
        kFloatBlock);
}

}  // namespace rivage::core
