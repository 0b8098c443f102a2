#include "client/download.h"

#include <charconv>

namespace rivage::client {
namespace {

/// The first byte of a Content-Range such as "bytes 10-99/100".
std::optional<std::uint64_t> rangeBegin(const std::string& field) {
    constexpr std::string_view kUnit = "bytes ";
    if (!field.starts_with(kUnit)) return std::nullopt;
    std::uint64_t begin = 0;
    const char* const end = field.data() + field.size();
    const auto [rest, error] = std::from_chars(field.data() + kUnit.size(), end, begin);
    return error == std::errc() && rest != end && *rest == '-' ? std::optional(begin)
                                                               : std::nullopt;
}

}  // namespace

void ResumedBody::prepare(httplib::Request& request) {
    request.set_header("Accept-Encoding", "identity");
    if (received_ == 0 || etag_.empty()) return;
    request.set_header("Range", "bytes=" + std::to_string(received_) + "-");
    request.set_header("If-Range", etag_);
}

bool ResumedBody::begin(const httplib::Response& head) {
    const std::string etag = head.get_header_value("ETag");
    const bool goesOn = head.status == 206 && received_ > 0 && etag == etag_ &&
                        rangeBegin(head.get_header_value("Content-Range")) == received_;
    if (!goesOn && !restart()) return false;
    stray_ = head.status == 206 && !goesOn;
    if (stray_) return true;
    etag_ = etag.starts_with('"') ? etag : std::string();
    promised_ = head.get_header_value("Repr-Digest");
    return true;
}

bool ResumedBody::write(std::string_view bytes) {
    if (stray_) return true;
    if (!store_.write(bytes)) return false;
    digest_.update(bytes);
    received_ += bytes.size();
    return true;
}

bool ResumedBody::restart() {
    digest_.restart();
    received_ = 0;
    etag_.clear();
    return store_.restart();
}

bool ResumedBody::intact() const { return !stray_ && !contradicts(promised_, digest_.field()); }

Outcome<void> download(Transport& transport, const std::string& path, const ByteStore& store,
                       bool patient) {
    for (const bool again : {false, true}) {
        if (again && !store.restart())
            return fail(ExitCode::notWritten, "The result could not be kept");
        ResumedBody body(store);
        const auto response = transport.send(makeRequest("GET", path), {&body, patient});
        if (!response) return tl::unexpected(response.error());
        if (response->status != 200 && response->status != 206)
            return fail(ExitCode::failed, "The server's answer is not understood",
                        "a result with the status " + std::to_string(response->status));
        if (body.intact()) return {};
    }
    return fail(ExitCode::unreachable, "The result arrived damaged",
                "twice its SHA-256 was not the one that the server names");
}

}  // namespace rivage::client
