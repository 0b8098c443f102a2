#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

/// Markdown tables whose rows say which limits they keep.
namespace rivage::test {

/// A figure and what it must stay below, stay at most at, or reach.
struct Limit {
    enum class Kind : std::uint8_t { below, atMost, atLeast };
    std::string what;
    Kind kind = Kind::below;
    double bound = 0;
    double value = 0;

    [[nodiscard]] bool kept() const {
        switch (kind) {  // a value that is not a number keeps none
            case Kind::below: return value < bound;
            case Kind::atMost: return value <= bound;
            case Kind::atLeast: return value >= bound;
        }
        return false;
    }
};

[[nodiscard]] inline Limit below(std::string what, double bound, double value) {
    return {std::move(what), Limit::Kind::below, bound, value};
}
[[nodiscard]] inline Limit atMost(std::string what, double bound, double value) {
    return {std::move(what), Limit::Kind::atMost, bound, value};
}
[[nodiscard]] inline Limit atLeast(std::string what, double bound, double value) {
    return {std::move(what), Limit::Kind::atLeast, bound, value};
}

[[nodiscard]] inline std::string decimals(double value, int digits) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

/// Prints tables row by row, so that a long run shows what it has, and counts broken limits.
class MarkdownReport {
public:
    /// A heading, a line of text (may be empty) and the head of a table; the column "limits" is
    /// added.
    void table(const std::string& title, const std::string& text,
               const std::vector<std::string>& columns) {
        std::printf("\n## %s\n\n", title.c_str());
        if (!text.empty()) std::printf("%s\n\n", text.c_str());
        printCells(columns, "limits");
        printCells(std::vector<std::string>(columns.size(), "---"), "---");
    }
    void row(const std::vector<std::string>& cells, const std::vector<Limit>& limits = {}) {
        std::string words;
        for (const Limit& limit : limits) {
            if (!words.empty()) words += ", ";
            words += wordsFor(limit);
            broken_ += limit.kept() ? 0 : 1;
        }
        printCells(cells, words);
    }
    [[nodiscard]] int broken() const { return broken_; }

private:
    static std::string wordsFor(const Limit& limit) {
        static constexpr const char* kSigns[] = {" < ", " <= ", " >= "};
        char bound[32];
        std::snprintf(bound, sizeof bound, "%.4g", limit.bound);
        const std::string words = limit.what + kSigns[static_cast<std::size_t>(limit.kind)] + bound;
        return limit.kept() ? words : "**BROKEN: " + words + "**";
    }
    static void printCells(const std::vector<std::string>& cells, const std::string& last) {
        for (const std::string& cell : cells) std::printf("| %s ", cell.c_str());
        std::printf("| %s |\n", last.c_str());
        std::fflush(stdout);
    }

    int broken_ = 0;
};

}  // namespace rivage::test
