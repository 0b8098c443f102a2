#pragma once

#include "core/solve/minimize.h"

namespace rivage::core {

/// Counts the steps of a solver and shows some of them to an observer: 1, 4, 16, 64, ...
class StepWatch {
public:
    StepWatch(const Observer& observer, const RunContext& run) : observer_(observer), run_(run) {}

    /// After each step.
    /// @param positions  gives the positions now; called only where they are shown
    template <typename Positions>
    void step(Positions&& positions) {
        if (!observer_ || ++step_ != next_) return;
        next_ *= 4;
        // What a solver that was asked to stop has got means nothing.
        if (!run_.stopped()) observer_(step_, positions());
    }

private:
    const Observer& observer_;
    const RunContext& run_;
    int step_ = 0;
    int next_ = 1;
};

/// Where an iterative solver begins, and who watches it.
struct Begin {
    const PointelVectors* positions;  ///< nullptr: the rest positions
    StepWatch& watch;
};

}  // namespace rivage::core
