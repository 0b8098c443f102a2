#include "server/http/body_decoder.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <vector>

#include "server/http/text.h"

namespace rivage::server {
namespace {

constexpr std::size_t kPieceBytes = 64 << 10;

/// 8 MiB: what RFC 9659 lets senders of the content coding use, and receivers must support.
constexpr int kZstdWindowLog = 23;

class ZlibDecoder final : public BodyDecoder {
public:
    /// Both zlib and gzip frames: what "deflate" means is told apart by the first bytes.
    ZlibDecoder() { valid_ = ::inflateInit2(&stream_, 15 + 32) == Z_OK; }
    ~ZlibDecoder() override { ::inflateEnd(&stream_); }
    ZlibDecoder(const ZlibDecoder&) = delete;
    ZlibDecoder& operator=(const ZlibDecoder&) = delete;

    bool take(const char* data, std::size_t size, const Sink& sink) override {
        if (!valid_) return false;
        stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data));
        stream_.avail_in = static_cast<uInt>(size);
        while (stream_.avail_in > 0 || pending_) {
            if (ended_ && !beginNextMember()) return false;
            stream_.next_out = reinterpret_cast<Bytef*>(out_.data());
            stream_.avail_out = static_cast<uInt>(out_.size());
            const int state = ::inflate(&stream_, Z_NO_FLUSH);
            if (state != Z_OK && state != Z_STREAM_END && state != Z_BUF_ERROR) return false;
            ended_ = state == Z_STREAM_END;
            pending_ = !ended_ && stream_.avail_out == 0;
            const std::size_t made = out_.size() - stream_.avail_out;
            if (made > 0 && !sink(out_.data(), made)) return false;
        }
        return true;
    }
    [[nodiscard]] bool atEnd() const override { return ended_; }

private:
    /// gzip data may be several members, one after the other; nothing else may follow.
    bool beginNextMember() {
        ended_ = false;
        return *stream_.next_in == 0x1f && ::inflateReset(&stream_) == Z_OK;
    }

    z_stream stream_{};
    std::vector<char> out_ = std::vector<char>(kPieceBytes);
    bool valid_ = false;
    bool pending_ = false;  ///< more may come without more input
    bool ended_ = false;
};

class ZstdDecoder final : public BodyDecoder {
public:
    ZstdDecoder() : context_(::ZSTD_createDCtx()) {
        if (context_) ::ZSTD_DCtx_setParameter(context_, ZSTD_d_windowLogMax, kZstdWindowLog);
    }
    ~ZstdDecoder() override { ::ZSTD_freeDCtx(context_); }
    ZstdDecoder(const ZstdDecoder&) = delete;
    ZstdDecoder& operator=(const ZstdDecoder&) = delete;

    bool take(const char* data, std::size_t size, const Sink& sink) override {
        if (!context_) return false;
        ZSTD_inBuffer input{data, size, 0};
        bool full = false;
        while (input.pos < input.size || full) {  // one frame or several
            ZSTD_outBuffer output{out_.data(), out_.size(), 0};
            const std::size_t hint = ::ZSTD_decompressStream(context_, &output, &input);
            if (::ZSTD_isError(hint) != 0) return false;
            ended_ = hint == 0;
            full = !ended_ && output.pos == output.size;
            if (output.pos > 0 && !sink(out_.data(), output.pos)) return false;
        }
        return true;
    }
    [[nodiscard]] bool atEnd() const override { return ended_; }

private:
    ZSTD_DCtx* context_;
    std::vector<char> out_ = std::vector<char>(kPieceBytes);
    bool ended_ = false;
};

enum class Coding : std::uint8_t { identity, zlib, zstd, unknown };

Coding codingOf(std::string_view encoding) {
    const std::string name = lowerCase(encoding);
    if (name.empty() || name == "identity") return Coding::identity;
    if (name == "gzip" || name == "x-gzip" || name == "deflate") return Coding::zlib;
    return name == "zstd" ? Coding::zstd : Coding::unknown;
}

}  // namespace

bool knowsEncoding(std::string_view encoding) { return codingOf(encoding) != Coding::unknown; }

std::unique_ptr<BodyDecoder> makeDecoder(std::string_view encoding) {
    switch (codingOf(encoding)) {
        case Coding::zlib: return std::make_unique<ZlibDecoder>();
        case Coding::zstd: return std::make_unique<ZstdDecoder>();
        case Coding::identity:
        case Coding::unknown: break;
    }
    return nullptr;
}

}  // namespace rivage::server
