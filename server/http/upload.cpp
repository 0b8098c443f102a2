#include "server/http/upload.h"

#include <algorithm>
#include <utility>

#include "server/http/body_decoder.h"
#include "server/http/form_parser.h"
#include "server/net/answer.h"

namespace rivage::server {
namespace {

using core::Error;
using core::ErrorCode;

constexpr const char* kShare = "upload-share";
constexpr std::size_t kMaxOptionsBytes = 64 << 10;
constexpr std::uint64_t kFormOverhead = kMaxOptionsBytes + (64 << 10);
constexpr std::uint64_t kFirstBytes = 64 << 10;  ///< of a grid whose length nobody has said

Error tooLarge(std::uint64_t limit, std::optional<std::uint64_t> actual) {
    Error error{ErrorCode::tooLarge, "the grid has more bytes than the server accepts", "/grid"};
    error.limit = limit;
    error.actual = actual;
    error.setting = "--max-upload";
    return error;
}

Error noRoom(const Service& service) {
    Error error{ErrorCode::busy, "the uploads in flight take all the memory that they may"};
    error.limit = service.uploads.limit;
    error.setting = "--upload-budget";
    return error;
}

Error wrongDigest(const char* field) {
    return {ErrorCode::digestMismatch, "the sha-256 of the body is another one", field};
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

/// Hides from the library what the body is, so that it hands over the bytes as they were sent: its
/// own decoders let a body choose their memory, and digests are of the bytes on the wire. The
/// request is an object that is not const; only handlers see it so.
class PlainBody {
public:
    explicit PlainBody(const httplib::Request& request)
        : headers_(const_cast<httplib::Request&>(request).headers), kept_(headers_) {
        headers_.erase("Content-Type");
        headers_.erase("Content-Encoding");
    }
    ~PlainBody() { headers_ = std::move(kept_); }
    PlainBody(const PlainBody&) = delete;
    PlainBody& operator=(const PlainBody&) = delete;

private:
    httplib::Headers& headers_;
    httplib::Headers kept_;
};

/// Takes the bytes of a body as they come, undoes its encoding and its form, and says no as soon
/// as it may.
class Collector {
public:
    Collector(Service& service, const UploadHead& head, UploadBudget::Share& share)
        : service_(service),
          share_(share),
          length_(head.encoding.empty() && !head.boundary ? head.length : std::nullopt),
          decoder_(makeDecoder(head.encoding)),
          sent_(head.contentDigest),
          meant_(head.reprDigest) {
        upload_.name = head.name;
        if (!head.boundary) return;
        form_.emplace(
            *head.boundary, [this](const FormPart& part) { return beginPart(part); },
            [this](const char* data, std::size_t size) { return keep(data, size); });
    }
    Collector(const Collector&) = delete;
    Collector& operator=(const Collector&) = delete;

    /// The next bytes from the network.
    bool take(const char* data, std::size_t size) {
        received_ += size;
        sent_.update(data, size);
        if (!decoder_) return decoded(data, size);
        return decoder_->take(data, size, [this](const char* piece, std::size_t bytes) {
            return decoded(piece, bytes);
        });
    }

    [[nodiscard]] std::uint64_t received() const { return received_; }

    /// The result, once the transport has ended with `complete`.
    Answer<Upload> finish(bool complete) {
        if (error_) return problem(*error_);
        if (complete && !sent_.matches()) return problem(wrongDigest("/headers/content-digest"));
        const bool whole = complete && (!decoder_ || received_ == 0 || decoder_->atEnd()) &&
                           (!form_ || form_->complete());
        if (!whole)
            return problem(
                {ErrorCode::malformedRequest, "the body is broken or incomplete", "/body"});
        if (!meant_.matches()) return problem(wrongDigest("/headers/repr-digest"));
        if (upload_.grid.empty())
            return problem({ErrorCode::malformedRequest,
                            "the request has no grid: send it as the body, or as the part grid "
                            "of a form",
                            "/grid"});
        return std::move(upload_);
    }

private:
    bool decoded(const char* data, std::size_t size) {
        meant_.update(data, size);
        return form_ ? form_->parse(data, size) : keep(data, size);
    }

    bool beginPart(const FormPart& part) {
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

    bool keep(const char* data, std::size_t size) {
        if (!toGrid_) {
            if (size > kMaxOptionsBytes - upload_.options.size())
                return refuse({ErrorCode::malformedRequest, "the options are too long", "/options",
                               kMaxOptionsBytes});
            upload_.options.append(data, size);
            return true;
        }
        const std::uint64_t limit = service_.limits.maxUploadBytes;
        if (size > limit - upload_.grid.size()) return refuse(tooLarge(limit, std::nullopt));
        if (!makeRoom(upload_.grid.size() + size)) return refuse(noRoom(service_));
        const auto* bytes = reinterpret_cast<const std::byte*>(data);
        upload_.grid.insert(upload_.grid.end(), bytes, bytes + size);
        return true;
    }

    /// Room for the whole grid if its length is known, else twice what there is.
    bool makeRoom(std::uint64_t bytes) {
        const std::uint64_t now = upload_.grid.capacity();
        if (bytes <= now) return true;
        const std::uint64_t next =
            std::min(std::max({bytes, 2 * now, length_.value_or(kFirstBytes)}),
                     service_.limits.maxUploadBytes);
        if (!share_.grow(next)) return false;
        upload_.grid.reserve(next);
        return true;
    }

    bool refuse(Error error) {
        error_ = std::move(error);
        return false;
    }

    const Service& service_;
    UploadBudget::Share& share_;
    const std::optional<std::uint64_t> length_;  ///< of the grid
    const std::unique_ptr<BodyDecoder> decoder_;
    DigestCheck sent_;
    DigestCheck meant_;
    std::optional<FormParser> form_;
    std::uint64_t received_ = 0;
    Upload upload_;
    std::optional<Error> error_;
    bool toGrid_ = true;
    bool hasGrid_ = false;
    bool hasOptions_ = false;
};

}  // namespace

Answer<UploadHead> readUploadHead(const httplib::Request& request, const Service& service) {
    UploadHead head;
    head.encoding = request.get_header_value("Content-Encoding");
    if (request.get_header_value_count("Content-Encoding") > 1 || !knowsEncoding(head.encoding))
        return tl::unexpected(
            proto::Problem{proto::transportProblemType(415),
                           "Content-Encoding must be gzip, deflate, zstd or identity, not " +
                               proto::inQuotes(head.encoding)});
    head.boundary = formBoundary(request.get_header_value("Content-Type"));
    if (head.boundary && head.boundary->empty())
        return problem({ErrorCode::malformedRequest, "the form has no valid boundary",
                        "/headers/content-type"});
    if (!head.boundary)
        head.name = safeStem(fileNameOf(request.get_header_value("Content-Disposition")));
    if (request.has_header("Content-Length"))
        head.length = request.get_header_value_u64("Content-Length");
    const std::uint64_t limit = service.limits.maxUploadBytes;
    const std::uint64_t overhead = head.boundary ? kFormOverhead : 0;
    if (head.length && *head.length > limit + overhead)
        return problem(tooLarge(limit, head.length));
    auto sent = digestHeader(request, "Content-Digest");
    if (!sent) return problem(sent.error());
    auto meant = digestHeader(request, "Repr-Digest");
    if (!meant) return problem(meant.error());
    head.contentDigest = *sent;
    head.reprDigest = *meant;
    return head;
}

Answer<void> admitUpload(const httplib::Request& request, httplib::Response& response,
                         Service& service) {
    const auto head = readUploadHead(request, service);
    if (!head) return tl::unexpected(head.error());
    auto share = std::make_shared<UploadBudget::Share>(service.uploads);
    if (!share->grow(std::min(head->length.value_or(0), service.limits.maxUploadBytes)))
        return problem(noRoom(service));
    response.user_data.set(kShare, std::move(share));
    return {};
}

Answer<Upload> readUpload(Exchange& exchange) {
    const auto head = readUploadHead(exchange.request, exchange.service);
    if (!head) return tl::unexpected(head.error());
    const auto share =
        *exchange.response.user_data.get<std::shared_ptr<UploadBudget::Share>>(kShare);
    exchange.response.user_data.erase(kShare);

    Collector collector(exchange.service, *head, *share);
    bool complete = false;
    {
        const PlainBody plain(exchange.request);
        complete = (*exchange.body)(
            [&](const char* data, std::size_t size) { return collector.take(data, size); });
    }
    exchange.response.user_data.set(kBytesIn, collector.received());
    if (bodyTimedOut(exchange.request))
        return tl::unexpected(
            proto::Problem{proto::transportProblemType(408), "the body comes too slowly", "/body"});
    if (!complete && exchange.response.status == 413)
        return problem(tooLarge(exchange.service.limits.maxUploadBytes, std::nullopt));
    return collector.finish(complete);
}

}  // namespace rivage::server
