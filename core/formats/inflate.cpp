#include "core/formats/inflate.h"

#include <zlib.h>

#include <algorithm>
#include <optional>

namespace rivage::core {
namespace {

constexpr std::size_t kFirst = std::size_t{64} << 10;  // bytes of room at the start
constexpr std::size_t kPiece = std::size_t{1} << 20;   // bytes between two polls

class Inflater {
public:
    explicit Inflater(std::span<const std::byte> packed) : packed_(packed) {
        constexpr int kEither = 15 + 32;  // the largest window, zlib or gzip by its header
        ready_ = inflateInit2(&stream_, kEither) == Z_OK;
    }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;
    ~Inflater() {
        if (ready_) inflateEnd(&stream_);
    }

    /// Fills `room` as far as there is something to fill it with.
    /// @return the bytes that were filled in; nothing if the stream is damaged or ends too early
    std::optional<std::size_t> next(std::span<std::byte> room) {
        std::size_t filled = 0;
        while (ready_ && filled < room.size() && !ended_) {
            feed();
            stream_.next_out = reinterpret_cast<Bytef*>(room.data() + filled);
            stream_.avail_out = static_cast<uInt>(room.size() - filled);
            const int state = inflate(&stream_, Z_NO_FLUSH);
            filled = room.size() - stream_.avail_out;
            if (state == Z_STREAM_END) {
                ended_ = !anotherMember();
                continue;
            }
            const bool starved = state == Z_BUF_ERROR && stream_.avail_in == 0 && packed_.empty();
            if (state != Z_OK || starved) return std::nullopt;
        }
        return ready_ ? std::optional(filled) : std::nullopt;
    }

private:
    /// zlib counts in 32 bits.
    void feed() {
        if (stream_.avail_in > 0) return;
        const std::size_t piece = std::min<std::size_t>(packed_.size(), kPiece);
        stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed_.data()));
        stream_.avail_in = static_cast<uInt>(piece);
        packed_ = packed_.subspan(piece);
    }
    bool anotherMember() {
        feed();
        constexpr Bytef kGzip = 0x1f;
        return stream_.avail_in > 0 && *stream_.next_in == kGzip && inflateReset(&stream_) == Z_OK;
    }

    std::span<const std::byte> packed_;
    z_stream stream_{};
    bool ready_ = false;
    bool ended_ = false;
};

}  // namespace

bool isGzip(std::span<const std::byte> bytes) {
    return bytes.size() > 2 && bytes[0] == std::byte{0x1f} && bytes[1] == std::byte{0x8b};
}

Result<std::vector<std::byte>> inflateUpTo(std::span<const std::byte> packed, std::uint64_t most,
                                           const RunContext& run) {
    Inflater inflater(packed);
    std::vector<std::byte> out;
    for (std::size_t filled = 0; filled < most;) {
        if (run.stopped()) return fail(run.stopError());
        const std::uint64_t room = std::clamp<std::uint64_t>(filled, kFirst, kPiece);
        out.resize(static_cast<std::size_t>(std::min<std::uint64_t>(most, filled + room)));
        const auto got = inflater.next(std::span(out).subspan(filled));
        if (!got)
            return fail(ErrorCode::malformedInput, "the packed values are damaged or incomplete",
                        "/grid");
        filled += *got;
        if (filled < out.size()) {
            out.resize(filled);
            break;
        }
    }
    return out;
}

}  // namespace rivage::core
