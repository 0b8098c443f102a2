#pragma once

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/ids.h"

namespace rivage::core {

/// How often each label covers a point: along a path each face that is passed takes 1 from the
/// label behind it and gives 1 to the label ahead, so the sum stays 1. Where the surface is not
/// folded over, one label has 1 and all others 0.
class Windings {
public:
    explicit Windings(Label start) : counts_{{start, 1}} {}

    void pass(Label from, Label to) {
        add(from, -1);
        add(to, 1);
    }
    /// The label that covers the point, if there is exactly one and nothing is folded.
    [[nodiscard]] std::optional<Label> only() const {
        if (counts_.size() != 1 || counts_[0].second != 1) return std::nullopt;
        return counts_[0].first;
    }
    /// The labels that cover the point most often; at least one.
    [[nodiscard]] std::vector<Label> most() const {
        int best = 0;
        for (const auto& [label, count] : counts_) best = std::max(best, count);
        std::vector<Label> labels;
        for (const auto& [label, count] : counts_)
            if (count == best) labels.push_back(label);
        std::sort(labels.begin(), labels.end());
        return labels;
    }
    [[nodiscard]] int of(Label label) const {
        for (const auto& [other, count] : counts_)
            if (other == label) return count;
        return 0;
    }
    [[nodiscard]] int sum() const {
        int total = 0;
        for (const auto& [label, count] : counts_) total += count;
        return total;
    }

private:
    void add(Label label, int change) {
        for (auto entry = counts_.begin(); entry != counts_.end(); ++entry) {
            if (entry->first != label) continue;
            entry->second += change;
            if (entry->second == 0) counts_.erase(entry);
            return;
        }
        counts_.emplace_back(label, change);
    }

    std::vector<std::pair<Label, int>> counts_;  // none is 0
};

}  // namespace rivage::core
