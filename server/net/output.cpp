#include "server/net/output.h"

#include <utility>

namespace rivage::server {

void Output::copy(std::string_view bytes) {
    if (bytes.empty()) return;
    auto kept = std::make_shared<const std::string>(bytes);
    const std::string_view view = *kept;
    copied_ += view.size();
    pieces_.push_back({std::move(kept), view, true});
}

void Output::lend(std::shared_ptr<const void> owner, std::string_view bytes) {
    if (!bytes.empty()) pieces_.push_back({std::move(owner), bytes, false});
}

Io Output::sendNow(Channel& channel, std::string_view bytes) {
    const Io io = channel.write(bytes);
    sent_ += io.bytes;
    return io;
}

IoStatus Output::flush(Channel& channel, std::size_t most) {
    for (const std::uint64_t begin = sent_; !pieces_.empty();) {
        if (sent_ - begin >= most) return IoStatus::wantWrite;
        Piece& piece = pieces_.front();
        const Io io = sendNow(channel, piece.bytes);
        if (io.status != IoStatus::done) return io.status;
        if (piece.copied) copied_ -= io.bytes;
        piece.bytes.remove_prefix(io.bytes);
        if (piece.bytes.empty()) pieces_.pop_front();
    }
    return IoStatus::done;
}

}  // namespace rivage::server
