#include "tests/study/samples.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace rivage::study {
namespace {

/// Six digits; nothing for NaN.
std::string cell(double value) {
    if (std::isnan(value)) return {};
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value == 0 ? 0.0 : value);
    return text;
}

std::string key(const Sample& s) {
    // Names of shapes and methods hold no quotes.
    return "\"" + s.shape + "\"," + std::to_string(s.resolution) + "," + std::to_string(s.pose) +
           ",\"" + s.method + "\"," + cell(s.level);
}

/// The cells of a line, quotes taken off.
std::vector<std::string> cells(const std::string& line) {
    std::vector<std::string> result(1);
    bool quoted = false;
    for (const char c : line) {
        if (c == '"') {
            quoted = !quoted;
        } else if (c == ',' && !quoted) {
            result.emplace_back();
        } else {
            result.back() += c;
        }
    }
    return result;
}

double number(const std::string& text) {
    return text.empty() ? std::numeric_limits<double>::quiet_NaN()
                        : std::strtod(text.c_str(), nullptr);
}

constexpr std::size_t kKeyCells = 5;

}  // namespace

bool writeSamples(const std::filesystem::path& folder, const std::string& section,
                  const Samples& samples) {
    std::ofstream csv(folder / (section + ".csv"));
    std::ofstream times(folder / (section + ".times.csv"));
    csv << "shape,resolution,pose,method,level";
    for (const std::string_view name : kMeasureNames) csv << ',' << name;
    csv << '\n';
    times << "shape,resolution,pose,method,level,ms\n";
    for (const Sample& sample : samples) {
        csv << key(sample);
        for (const double value : sample.measures.values) csv << ',' << cell(value);
        csv << '\n';
        times << key(sample) << ',' << cell(sample.milliseconds) << '\n';
    }
    csv.close();
    times.close();
    return !csv.fail() && !times.fail();
}

std::optional<Samples> readSamples(const std::filesystem::path& folder,
                                   const std::string& section) {
    std::ifstream csv(folder / (section + ".csv"));
    std::ifstream times(folder / (section + ".times.csv"));
    std::string line;
    std::string timesLine;
    if (!std::getline(csv, line)) return std::nullopt;
    std::getline(times, timesLine);
    Samples samples;
    while (std::getline(csv, line)) {
        const std::vector<std::string> row = cells(line);
        if (row.size() != kKeyCells + kMeasures) return std::nullopt;
        Sample& s = samples.emplace_back();
        s.shape = row[0];
        s.resolution = static_cast<int>(number(row[1]));
        s.pose = static_cast<int>(number(row[2]));
        s.method = row[3];
        s.level = number(row[4]);
        for (std::size_t i = 0; i < kMeasures; ++i)
            s.measures.values[i] = number(row[kKeyCells + i]);
        if (std::getline(times, timesLine)) s.milliseconds = number(cells(timesLine).back());
    }
    return samples;
}

}  // namespace rivage::study
