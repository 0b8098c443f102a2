#include "client/compare/compare.h"

#include <cstdio>
#include <filesystem>
#include <map>
#include <system_error>

#include "client/commands/local.h"
#include "client/commands/session.h"
#include "client/inputs.h"
#include "client/printable.h"

namespace rivage::client {
namespace {

using proto::Json;

bool isFolder(const std::string& path) {
    std::error_code ignored;
    return std::filesystem::is_directory(path, ignored);
}

/// What is wrong is said of the file that it is wrong with.
struct Comparison {
    Outcome<Json> result;
    std::string about = {};
};

Comparison compareFiles(const CompareSettings& settings, Console& console,
                        const Interrupt& interrupt) {
    const auto a = readInput(settings.nameA, console, interrupt);
    if (!a) return {tl::unexpected(a.error()), settings.nameA};
    const auto b = readInput(settings.nameB, console, interrupt);
    if (!b) return {tl::unexpected(b.error()), settings.nameB};
    return {compareAssets(*a, *b, settings)};
}

/// The results below a folder, by their path there; of each its whole path.
using Results = std::map<std::string, std::string>;

Outcome<Results> resultsBelow(const std::string& folder) {
    const auto found = findInputs({folder}, {".glb", ".obj"}, true);
    if (!found) return tl::unexpected(found.error());
    if (!found->unread.empty())
        return fail(ExitCode::usage, "The folder cannot be read",
                    found->unread.front().path + ": " + found->unread.front().why);
    Results results;
    for (const InputFile& file : found->files) results[file.below] = file.path;
    return results;
}

/// Two folders, one file after the other.
class FolderComparison {
public:
    FolderComparison(const Invocation& invocation, Console& console, const Interrupt& interrupt)
        : invocation_(invocation), console_(console), interrupt_(interrupt) {}

    ExitCode run(const Results& a, const Results& b) {
        for (const auto& [name, path] : a) {
            if (interrupt_.requested()) return ExitCode::cancelled;
            if (const auto other = b.find(name); other != b.end())
                compare(name, path, other->second);
            else
                alone(name, invocation_.inputs[0]);
        }
        for (const auto& [name, path] : b)
            if (a.count(name) == 0) alone(name, invocation_.inputs[1]);
        summarize();
        if (first_ != ExitCode::ok) return first_;
        const bool incomplete = alone_ > 0 && invocation_.compare.maxDistance.has_value();
        return exceeded_ > 0 || incomplete ? ExitCode::failed : ExitCode::ok;
    }

private:
    void compare(const std::string& name, const std::string& a, const std::string& b) {
        CompareSettings settings = invocation_.compare;
        settings.nameA = a;
        settings.nameB = b;
        const Comparison comparison = compareFiles(settings, console_, interrupt_);
        if (!comparison.result) {
            const Failure& failure = comparison.result.error();
            const std::string& about = comparison.about.empty() ? name : comparison.about;
            complain(invocation_, console_, about, failure);
            if (first_ == ExitCode::ok) first_ = failure.exit;
            ++failed_;
            return;
        }
        const Json& json = *comparison.result;
        const bool exceeded = exitOf(json) != ExitCode::ok;
        const std::string kind = textOf(json["verdict"], "kind");
        ++(exceeded ? exceeded_ : kind == "different" ? different_ : same_);
        std::string words = textOf(json["verdict"], "text");
        if (exceeded) words += ", more than --max-distance";
        tell(name, words, json);
    }

    void alone(const std::string& name, const std::string& folder) {
        ++alone_;
        tell(name, "only in " + folder, {{"only_in", folder}});
    }

    void tell(const std::string& name, const std::string& words, Json json) {
        if (invocation_.json) {
            json["file"] = name;
            console_.out << jsonLine(json) << std::flush;
            return;
        }
        constexpr std::size_t kName = 32;
        const std::string shown = printable(name);
        console_.out << shown << std::string(shown.size() < kName ? kName - shown.size() : 1, ' ')
                     << ' ' << printable(words) << "\n"
                     << std::flush;
    }

    void summarize() {
        if (invocation_.json) return;
        std::string text = std::to_string(same_) + " same";
        const auto add = [&text](std::size_t count, const char* words) {
            if (count > 0) text += ", " + std::to_string(count) + " " + words;
        };
        add(different_, "different");
        add(exceeded_, "beyond --max-distance");
        add(alone_, "without partner");
        add(failed_, "not compared");
        console_.out << text << "\n";
    }

    const Invocation& invocation_;
    Console& console_;
    const Interrupt& interrupt_;
    std::size_t same_ = 0;
    std::size_t different_ = 0;
    std::size_t exceeded_ = 0;
    std::size_t alone_ = 0;
    std::size_t failed_ = 0;
    ExitCode first_ = ExitCode::ok;  ///< of the first file that could not be compared
};

ExitCode compareFolders(const Invocation& invocation, Console& console,
                        const Interrupt& interrupt) {
    const auto a = resultsBelow(invocation.inputs[0]);
    if (!a) return complain(invocation, console, {}, a.error());
    const auto b = resultsBelow(invocation.inputs[1]);
    if (!b) return complain(invocation, console, {}, b.error());
    if (a->empty() && b->empty())
        return complain(invocation, console, {},
                        failureWith(ExitCode::usage, "There is nothing to compare",
                                    "neither folder holds a .glb or .obj"));
    return FolderComparison(invocation, console, interrupt).run(*a, *b);
}

}  // namespace

ExitCode runCompare(const Invocation& invocation, Console& console, const Interrupt& interrupt) {
    const bool folders = isFolder(invocation.inputs[0]);
    if (folders != isFolder(invocation.inputs[1]))
        return complain(invocation, console, {},
                        failureWith(ExitCode::usage, "A file and a folder cannot be compared",
                                    "name two files or two folders"));
    if (folders) return compareFolders(invocation, console, interrupt);
    CompareSettings settings = invocation.compare;
    settings.nameA = invocation.inputs[0];
    settings.nameB = invocation.inputs[1];
    const Comparison comparison = compareFiles(settings, console, interrupt);
    if (!comparison.result)
        return complain(invocation, console, comparison.about, comparison.result.error());
    console.out << (invocation.json ? jsonLine(*comparison.result)
                                    : comparisonTable(*comparison.result))
                << std::flush;
    // Without what was printed nobody knows; runCommand says so.
    return console.out ? exitOf(*comparison.result) : ExitCode::ok;
}

}  // namespace rivage::client
