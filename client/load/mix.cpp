#include "client/load/mix.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

namespace rivage::client::load {
namespace {

using proto::Json;

/// Reads the members of one object, each at most once and each known. The first mistake stays.
class ObjectReader {
public:
    ObjectReader(const Json& json, std::string pointer, std::optional<Failure>& failure)
        : json_(json), pointer_(std::move(pointer)), failure_(failure) {
        if (!json_.is_object()) refuse("", "expected an object");
    }

    /// Calls `use` with the member and its pointer, if it is there.
    void member(const std::string& name,
                const std::function<void(const Json&, const std::string&)>& use) {
        known_.push_back(name);
        if (failure_ || !json_.is_object() || !json_.contains(name)) return;
        use(json_[name], pointer_ + "/" + name);
    }
    void number(const std::string& name, double& value, double least, double most) {
        member(name, [&](const Json& json, const std::string&) {
            // Written so that NaN is refused too.
            const double read = json.is_number() ? json.get<double>() : least - 1;
            if (!(read >= least && read <= most))
                return refuse("/" + name, "expected a number from " + numberText(least, 6) +
                                              " to " + numberText(most, 6));
            value = read;
        });
    }
    void text(const std::string& name, std::string& value) {
        member(name, [&](const Json& json, const std::string&) {
            if (!json.is_string() || json.get<std::string>().empty())
                return refuse("/" + name, "expected a text");
            value = json.get<std::string>();
        });
    }
    void time(const std::string& name, std::chrono::milliseconds& value) {
        member(name, [&](const Json& json, const std::string&) {
            const auto read = json.is_string() ? readTime(json.get<std::string>()) : std::nullopt;
            if (!read || *read < 1000)
                return refuse("/" + name,
                              "expected a time such as \"500ms\" or \"2s\", from 1ms to 3600s");
            value = std::chrono::milliseconds(*read / 1000);
        });
    }
    template <typename T>
    void word(const std::string& name, T& value, const std::map<std::string, T>& words) {
        member(name, [&](const Json& json, const std::string&) {
            std::string list;
            for (const auto& [one, meaning] : words) list += (list.empty() ? "" : ", ") + one;
            const auto found = json.is_string() ? words.find(json.get<std::string>()) : words.end();
            if (found == words.end()) return refuse("/" + name, "expected one of " + list);
            value = found->second;
        });
    }
    /// After all members: what is not known is refused.
    void finish() {
        if (failure_) return;
        for (const auto& [name, value] : json_.items())
            if (std::find(known_.begin(), known_.end(), name) == known_.end())
                return refuse("/" + name, "there is no such member");
    }
    void refuse(const std::string& member, const std::string& why) {
        if (failure_) return;
        failure_ = fail(ExitCode::usage, "The mix cannot be used", why).value();
        failure_->problem["field"] = pointer_ + member;
    }

private:
    const Json& json_;
    std::string pointer_;
    std::optional<Failure>& failure_;
    std::vector<std::string> known_;
};

void readInput(const Json& json, const std::string& pointer, MixEntry& entry,
               std::optional<Failure>& failure) {
    ObjectReader reader(json, pointer, failure);
    reader.text("sample", entry.sample);
    reader.text("file", entry.file);
    reader.finish();
    if (entry.sample.empty() == entry.file.empty())
        reader.refuse("", "expected either a sample or a file");
}

/// Options as the wire names them; what the server would refuse is refused before it is asked.
void readOptions(const Json& json, const std::string& pointer, MixEntry& entry,
                 std::optional<Failure>& failure) {
    const ObjectReader shape(json, pointer, failure);
    if (failure) return;
    for (const auto& [name, value] : json.items())
        entry.options.push_back(
            {name, value.is_string() ? value.get<std::string>() : proto::writeJson(value)});
    const auto valid = proto::parseOptions(entry.options);
    if (valid) return;
    failure = fail(ExitCode::usage, "The mix cannot be used", valid.error().message).value();
    const std::string& field = valid.error().field;
    const std::size_t slash = field.rfind('/');
    failure->problem["field"] = pointer + (slash == std::string::npos ? "" : field.substr(slash));
}

void readJobMembers(ObjectReader& reader, MixEntry& entry) {
    reader.word<Follow>(
        "follow", entry.follow,
        {{"events", Follow::events}, {"poll", Follow::poll}, {"wait", Follow::wait}});
    reader.time("poll_every", entry.pollEvery);
    reader.number("abandoned", entry.abandoned, 0, 1);
    reader.number("cancelled", entry.cancelled, 0, 1);
    reader.time("cancel_after", entry.cancelAfter);
    if (entry.abandoned + entry.cancelled > 1)
        reader.refuse("/cancelled", "abandoned and cancelled are together more than 1");
}

MixEntry readEntry(const Json& json, const std::string& pointer, std::optional<Failure>& failure) {
    MixEntry entry;
    ObjectReader reader(json, pointer, failure);
    reader.text("name", entry.name);
    reader.number("weight", entry.weight, 0, 1e6);
    reader.word<Mode>("mode", entry.mode,
                      {{"get", Mode::get}, {"job", Mode::job}, {"sync", Mode::sync}});
    if (entry.mode == Mode::get) {
        reader.text("path", entry.path);
        const bool plain = std::all_of(entry.path.begin(), entry.path.end(),
                                       [](char c) { return c > 0x20 && c < 0x7f; });
        if (!plain || !entry.path.starts_with('/'))
            reader.refuse("/path",
                          "expected a path that begins with /, without blanks, control characters "
                          "and non-ASCII");
    } else {
        entry.sample = "island";
        reader.member("input", [&](const Json& input, const std::string& at) {
            entry.sample.clear();
            readInput(input, at, entry, failure);
        });
        reader.member("options", [&](const Json& options, const std::string& at) {
            readOptions(options, at, entry, failure);
        });
    }
    if (entry.mode == Mode::job) readJobMembers(reader, entry);
    reader.finish();
    if (entry.name.empty())
        entry.name = entry.mode == Mode::get ? entry.path
                     : entry.sample.empty()  ? entry.file
                                             : entry.sample;
    return entry;
}

void readEntries(const Json& json, const std::string& pointer, Mix& mix,
                 std::optional<Failure>& failure) {
    ObjectReader list(Json::object(), pointer, failure);
    if (!json.is_array() || json.empty()) return list.refuse("", "expected a list of entries");
    double weights = 0;
    for (std::size_t i = 0; i < json.size(); ++i) {
        const std::string at = "/" + std::to_string(i);
        mix.entries.push_back(readEntry(json[i], pointer + at, failure));
        weights += mix.entries.back().weight;
        const auto names = mix.names();
        if (std::count(names.begin(), names.end(), names.back()) > 1)
            list.refuse(at + "/name", "two entries have the name " + names.back());
    }
    if (weights <= 0) list.refuse("", "the weights add up to 0");
}

void readThresholds(const Json& json, const std::string& pointer, Mix& mix,
                    std::optional<Failure>& failure) {
    static constexpr std::array kRatios{"errors", "refused", "not_sent"};
    ObjectReader reader(json, pointer, failure);
    if (failure) return;
    for (const auto& [name, value] : json.items()) {
        Threshold threshold{name};
        if (name == "max" || readPercentile(name)) {
            const auto time = value.is_string() ? readTime(value.get<std::string>()) : std::nullopt;
            if (!time)
                return reader.refuse("/" + name,
                                     "expected a time such as \"500ms\", from 1us to 3600s");
            threshold.limit = static_cast<double>(*time);
        } else {
            const bool ratio = std::find(kRatios.begin(), kRatios.end(), name) != kRatios.end();
            if (!ratio && name != "goodput")
                return reader.refuse("/" + name,
                                     "expected p50 ... p99.99, max, errors, refused, not_sent or "
                                     "goodput");
            reader.number(name, threshold.limit, 0, ratio ? 1 : 1e9);
        }
        mix.thresholds.push_back(std::move(threshold));
    }
}

void readRatios(ObjectReader& reader, Mix& mix) {
    reader.number("duplicates", mix.duplicates, 0, 1);
    reader.number("aborts", mix.aborts, 0, 1);
    reader.time("abort_after", mix.abortAfter);
    reader.number("slow_clients", mix.slowClients, 0, 1);
    reader.number("slow_rate", mix.slowRate, 1, 1e9);
}

}  // namespace

std::vector<std::string> Mix::names() const {
    std::vector<std::string> result;
    for (const MixEntry& entry : entries) result.push_back(entry.name);
    return result;
}

Outcome<Mix> parseMix(std::string_view text, const std::string& where) {
    const auto json = proto::readJson(text, "");
    if (!json)
        return fail(ExitCode::usage, "The mix " + proto::inQuotes(where) + " is no JSON",
                    json.error().message);
    Mix mix;
    std::optional<Failure> failure;
    ObjectReader reader(*json, "", failure);
    bool entries = false;
    reader.member("entries", [&](const Json& list, const std::string& at) {
        entries = true;
        readEntries(list, at, mix, failure);
    });
    if (!entries) reader.refuse("/entries", "the list of entries is missing");
    readRatios(reader, mix);
    reader.member("seed", [&](const Json& seed, const std::string&) {
        if (!seed.is_number_unsigned()) return reader.refuse("/seed", "expected a whole number");
        mix.seed = seed.get<std::uint64_t>();
    });
    reader.member("slo", [&](const Json& slo, const std::string&) {
        if (slo.is_string()) mix.slo = readSlo(slo.get<std::string>());
        if (!mix.slo) reader.refuse("/slo", kSloForm);
    });
    reader.member("thresholds", [&](const Json& list, const std::string& at) {
        readThresholds(list, at, mix, failure);
    });
    reader.finish();
    if (failure) {
        failure->problem["title"] = "The mix " + proto::inQuotes(where) + " cannot be used";
        return tl::unexpected(*std::move(failure));
    }
    return mix;
}

Mix defaultMix() {
    Mix mix;
    mix.entries.push_back({.name = "island", .sample = "island"});
    return mix;
}

Mix plainMix(const std::string& path) {
    Mix mix;
    mix.entries.push_back({.name = path, .mode = Mode::get, .path = path});
    return mix;
}

}  // namespace rivage::client::load
