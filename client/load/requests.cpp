#include "client/load/requests.h"

#include <map>
#include <utility>

#include "client/load/input_file.h"
#include "client/transport.h"
#include "client/upload.h"

namespace rivage::client::load {
namespace {

constexpr const char* kFresh = "Cache-Control: no-cache\r\n";

/// More than any server takes.
constexpr InputBounds kGrid{.bytes = std::size_t{1} << 30};

Outcome<std::string> readGrid(const std::string& path, const Interrupt& interrupt) {
    auto bytes = readInput("grid", path, kGrid, interrupt);
    if (bytes && bytes->empty())
        return fail(ExitCode::usage, "The grid " + proto::inQuotes(path) + " cannot be read",
                    "it is empty");
    return bytes;
}

/// The grids of a mix, each read or fetched once.
class Grids {
public:
    Grids(const ServerAccess& server, Interrupt& interrupt)
        : interrupt_(interrupt), transport_(server, interrupt, {.tries = 1}) {}

    Outcome<std::string> get(const MixEntry& entry) {
        const std::string key = entry.sample.empty() ? "file:" + entry.file : entry.sample;
        if (const auto known = known_.find(key); known != known_.end()) return known->second;
        Outcome<std::string> bytes;
        if (entry.sample.empty()) {
            bytes = readGrid(entry.file, interrupt_);
        } else {
            auto answer = transport_.send(makeRequest("GET", "/v1/samples/" + entry.sample));
            if (!answer) return tl::unexpected(answer.error());
            bytes = std::move(answer->body);
        }
        if (bytes) known_[key] = *bytes;
        return bytes;
    }

private:
    const Interrupt& interrupt_;
    Transport transport_;
    std::map<std::string, std::string> known_;
};

void writeConversion(PreparedEntry& prepared, const HeadWriter& heads, std::string grid) {
    const MixEntry& entry = prepared.entry;
    httplib::Request request = makeUpload(entry.mode == Mode::job ? "/v1/jobs" : "/v1/regularize",
                                          {std::move(grid), entry.options});
    const std::string type = "Content-Type: " + request.get_header_value("Content-Type") + "\r\n";
    prepared.body = std::move(request.body);
    prepared.kept = heads.write("POST", request.path, type, prepared.body.size());
    prepared.fresh = heads.write("POST", request.path, type + kFresh, prepared.body.size());
}

}  // namespace

HeadWriter::HeadWriter(std::string host, const std::string& apiKey)
    : common_(" HTTP/1.1\r\nHost: " + std::move(host) + "\r\nUser-Agent: rivage-load\r\n") {
    if (!apiKey.empty()) common_ += "Authorization: Bearer " + apiKey + "\r\n";
}

std::string HeadWriter::write(std::string_view method, std::string_view path,
                              std::string_view fields) const {
    std::string head(method);
    head.append(" ").append(path).append(common_).append(fields).append("\r\n");
    return head;
}

std::string HeadWriter::write(std::string_view method, std::string_view path,
                              std::string_view fields, std::size_t bodySize) const {
    return write(method, path,
                 std::string(fields) + "Content-Length: " + std::to_string(bodySize) + "\r\n");
}

Outcome<PreparedMix> prepareMix(const Mix& mix, const ServerAccess& server, const Target& target,
                                Interrupt& interrupt) {
    PreparedMix prepared{mix, {}, HeadWriter(target.host, server.apiKey)};
    Grids grids(server, interrupt);
    for (const MixEntry& entry : mix.entries) {
        PreparedEntry& one = prepared.entries.emplace_back(PreparedEntry{.entry = entry});
        if (entry.mode == Mode::get) {
            one.fresh = one.kept = prepared.heads.write("GET", entry.path);
            continue;
        }
        auto grid = grids.get(entry);
        if (!grid) return tl::unexpected(grid.error());
        writeConversion(one, prepared.heads, *std::move(grid));
    }
    return prepared;
}

}  // namespace rivage::client::load
