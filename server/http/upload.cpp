#include "server/http/upload.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace rivage::server {
namespace {

using core::Error;
using core::ErrorCode;

constexpr std::size_t kMaxOptionsBytes = 64 << 10;
constexpr std::uint64_t kFormOverhead = kMaxOptionsBytes + (64 << 10);

Error tooLarge(std::uint64_t limit, std::optional<std::uint64_t> actual) {
    Error error{ErrorCode::tooLarge, "the grid has more bytes than the server accepts", "/grid"};
    error.limit = limit;
    error.actual = actual;
    error.setting = "--max-upload";
    return error;
}

/// "dir/My Island.vox" -> "My_Island"; what is left is safe in a header and as a file name.
std::string safeStem(std::string name) {
    name = name.substr(name.find_last_of("/\\") + 1);
    name = name.substr(0, name.rfind('.'));
    for (char& c : name) {
        const bool plain =
            (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
        if (!plain) c = '_';
    }
    return name.substr(0, 64);
}

/// Takes the pieces of a body as they come, and says no as soon as it may.
class Collector {
public:
    explicit Collector(const Service& service) : service_(service) {}

    bool beginPart(const httplib::FormData& part) {
        if (part.name == "grid" && !std::exchange(hasGrid_, true)) {
            upload_.name = safeStem(part.filename);
            toGrid_ = true;
            return true;
        }
        if (part.name == "options" && !std::exchange(hasOptions_, true)) {
            toGrid_ = false;
            return true;
        }
        const bool known = part.name == "grid" || part.name == "options";
        return refuse(
            {ErrorCode::malformedRequest,
             known ? "the form has the part " + part.name + " twice"
                   : "a form has the parts grid and options, not " + proto::inQuotes(part.name)});
    }

    bool take(const char* data, std::size_t size) {
        if (tooSlow(size)) return false;
        if (!toGrid_) {
            if (size > kMaxOptionsBytes - upload_.options.size())
                return refuse({ErrorCode::malformedRequest, "the options are too long", "/options",
                               kMaxOptionsBytes});
            upload_.options.append(data, size);
            return true;
        }
        const std::uint64_t limit = service_.limits.maxUploadBytes;
        if (size > limit - upload_.grid.size()) return refuse(tooLarge(limit, std::nullopt));
        const auto* bytes = reinterpret_cast<const std::byte*>(data);
        upload_.grid.insert(upload_.grid.end(), bytes, bytes + size);
        return true;
    }

    /// The result, once the transport has ended with `complete`.
    Answer<Upload> finish(bool complete) {
        const bool stopped = !complete && Clock::now() - last_ >= service_.readTimeout;
        if (slow_ || (stopped && !error_))
            return tl::unexpected(proto::Problem{proto::transportProblemType(408),
                                                 "the body comes too slowly", "/body"});
        if (error_) return problem(*error_);
        if (!complete)
            return problem(
                {ErrorCode::malformedRequest, "the body is broken or incomplete", "/body"});
        if (upload_.grid.empty())
            return problem({ErrorCode::malformedRequest,
                            "the request has no grid: send it as the body, or as the part grid "
                            "of a form",
                            "/grid"});
        return std::move(upload_);
    }

private:
    bool refuse(Error error) {
        error_ = std::move(error);
        return false;
    }

    bool tooSlow(std::size_t size) {
        last_ = Clock::now();
        received_ += size;
        const double seconds = std::chrono::duration<double>(last_ - began_).count();
        const double grace = static_cast<double>(service_.readTimeout.count());
        const double needed = (seconds - grace) * static_cast<double>(service_.minBodyRate);
        if (seconds <= grace || static_cast<double>(received_) >= needed) return false;
        return slow_ = true;
    }

    const Service& service_;
    const Clock::time_point began_ = Clock::now();
    Clock::time_point last_ = began_;
    std::uint64_t received_ = 0;
    Upload upload_;
    std::optional<Error> error_;
    bool toGrid_ = true;
    bool hasGrid_ = false;
    bool hasOptions_ = false;
    bool slow_ = false;
};

}  // namespace

Answer<void> checkUploadHeaders(const httplib::Request& request, const Service& service) {
    const std::string encoding = request.get_header_value("Content-Encoding");
    if (!encoding.empty() && encoding != "identity" && encoding != "gzip" && encoding != "deflate")
        return tl::unexpected(
            proto::Problem{proto::transportProblemType(415),
                           "Content-Encoding must be gzip, deflate or identity, not " +
                               proto::inQuotes(encoding)});
    const std::uint64_t limit = service.limits.maxUploadBytes;
    const std::uint64_t length = request.get_header_value_u64("Content-Length");
    const std::uint64_t overhead = request.is_multipart_form_data() ? kFormOverhead : 0;
    if (length > limit + overhead) return problem(tooLarge(limit, length));
    return {};
}

Answer<Upload> readUpload(Exchange& exchange) {
    Collector collector(exchange.service);
    const auto take = [&](const char* data, std::size_t size) {
        return collector.take(data, size);
    };
    const httplib::ContentReader& body = *exchange.body;
    const bool complete =
        exchange.request.is_multipart_form_data()
            ? body([&](const httplib::FormData& part) { return collector.beginPart(part); }, take)
            : body(take);
    if (!complete && exchange.response.status == 413)
        return problem(tooLarge(exchange.service.limits.maxUploadBytes, std::nullopt));
    return collector.finish(complete);
}

}  // namespace rivage::server
