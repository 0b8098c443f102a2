#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "tests/study/report.h"
#include "tests/study/sections.h"

// run_study --out FOLDER [--quick] [--poses N] [--largest N] [--threads N] [--commit NAME]
//           [SECTION...]
// Measures the sections named (all, if none is; `report` names none) and writes their samples, then
// RESULTS.md and its plots from all samples in the folder.

using namespace rivage::study;

namespace {

struct Arguments {
    std::filesystem::path out;
    std::string commit = "unknown";
    Effort scale;
    std::vector<std::string> sections;
};

[[noreturn]] void refuse(const std::string& why) {
    std::fprintf(stderr,
                 "%s\nusage: run_study --out FOLDER [--quick] [--poses N] [--largest N] "
                 "[--threads N] [--commit NAME] [SECTION... | report]\nsections:",
                 why.c_str());
    for (const std::string& name : sectionNames()) std::fprintf(stderr, " %s", name.c_str());
    std::fprintf(stderr, "\n");
    std::exit(2);
}

int count(const std::string& flag, const std::string& text, int most) {
    char* end = nullptr;
    const long value = std::strtol(text.c_str(), &end, 10);
    if (text.empty() || *end != '\0' || value < 1 || value > most)
        refuse(flag + " takes a number from 1 to " + std::to_string(most));
    return static_cast<int>(value);
}

void addSection(const std::string& name, std::vector<std::string>& sections) {
    const auto& known = sectionNames();
    if (name != "report" && std::find(known.begin(), known.end(), name) == known.end())
        refuse("no section '" + name + "'");
    sections.push_back(name);
}

void makeQuick(Effort& scale) {
    scale.quick = true;
    scale.poses = 2;
    scale.resolution = 16;
    scale.largest = 32;
}

int cores() { return static_cast<int>(std::max(1U, std::thread::hardware_concurrency())); }

Arguments parse(const std::vector<std::string>& words) {
    constexpr int kMost = 1024;
    Arguments arguments;
    arguments.scale.threads = cores();
    for (std::size_t i = 0; i < words.size(); ++i) {
        const std::string& word = words[i];
        const auto value = [&]() -> const std::string& {
            if (i + 1 == words.size()) refuse(word + " needs a value");
            return words[++i];
        };
        if (word == "--quick") {
            makeQuick(arguments.scale);
        } else if (word == "--out") {
            arguments.out = value();
        } else if (word == "--commit") {
            arguments.commit = value();
        } else if (word == "--poses") {
            arguments.scale.poses = count(word, value(), kMost);
        } else if (word == "--largest") {
            arguments.scale.largest = count(word, value(), kMost);
        } else if (word == "--threads") {
            arguments.scale.threads = count(word, value(), kMost);
        } else {
            addSection(word, arguments.sections);
        }
    }
    if (arguments.out.empty()) refuse("--out is missing");
    if (arguments.sections.empty()) arguments.sections = sectionNames();
    return arguments;
}

double seconds(std::chrono::steady_clock::time_point since) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - since).count();
}

bool writeFile(const std::filesystem::path& path, const std::string& text) {
    std::ofstream file(path);
    file << text;
    file.close();
    if (file.fail()) std::fprintf(stderr, "cannot write %s\n", path.c_str());
    return !file.fail();
}

/// The seconds that a section took when it was measured last.
std::filesystem::path secondsFile(const Arguments& arguments, const std::string& section) {
    return arguments.out / (section + ".seconds");
}

bool measureSection(const Arguments& arguments, const std::string& section) {
    std::fprintf(stderr, "study: %s ...", section.c_str());
    const auto since = std::chrono::steady_clock::now();
    const Samples samples = runSection(section, arguments.scale);
    const double spent = seconds(since);
    std::fprintf(stderr, " %zu runs, %.0f s\n", samples.size(), spent);
    return writeSamples(arguments.out, section, samples) &&
           writeFile(secondsFile(arguments, section), std::to_string(spent) + "\n");
}

bool report(const Arguments& arguments) {
    Measured measured;
    RunFacts facts{arguments.commit, {}, arguments.scale.threads, cores()};
    std::array<double, 3> loads{};
    if (getloadavg(loads.data(), 3) == 3) facts.load = loads[2];
    for (const std::string& section : sectionNames()) {
        auto samples = readSamples(arguments.out, section);
        if (!samples) continue;
        measured[section] = *std::move(samples);
        std::ifstream file(secondsFile(arguments, section));
        file >> facts.seconds[section];
    }
    bool written = writeFile(arguments.out / "RESULTS.md", writeReport(measured, facts));
    for (const auto& [name, svg] : drawPlots(measured))
        written = writeFile(arguments.out / "plots" / (name + ".svg"), svg) && written;
    return written;
}

}  // namespace

int main(int argc, char** argv) {
    const Arguments arguments = parse({argv + 1, argv + argc});
    std::error_code error;
    std::filesystem::create_directories(arguments.out / "plots", error);
    if (error) {
        std::fprintf(stderr, "cannot make the folder %s: %s\n", arguments.out.c_str(),
                     error.message().c_str());
        return 1;
    }
    for (const std::string& section : arguments.sections)
        if (section != "report" && !measureSection(arguments, section)) return 1;
    return report(arguments) ? 0 : 1;
}
