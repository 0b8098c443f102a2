#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "server/net/channel.h"

namespace rivage::server {

/// Bytes that somebody keeps alive and nobody changes, so that they can be sent without a copy.
struct Lent {
    std::shared_ptr<const void> owner;
    std::string_view bytes;

    [[nodiscard]] bool holds(std::string_view part) const {
        return !bytes.empty() && part.data() >= bytes.data() &&
               part.data() + part.size() <= bytes.data() + bytes.size();
    }
};

/// What a connection still has to send, in its order: copies, and bytes that were lent.
class Output {
public:
    void copy(std::string_view bytes);
    void lend(std::shared_ptr<const void> owner, std::string_view bytes);

    [[nodiscard]] bool empty() const { return pieces_.empty(); }
    [[nodiscard]] std::size_t copiedBytes() const { return copied_; }
    /// Bytes that the system has taken, since the connection began.
    [[nodiscard]] std::uint64_t sent() const { return sent_; }

    /// Sends bytes that are not in the queue, which must be empty. @return as `Channel::write`
    Io sendNow(Channel& channel, std::string_view bytes);
    /// Sends until the queue is empty, the socket takes no more, or `most` bytes are on their way:
    /// then it is as if the socket took no more.
    IoStatus flush(Channel& channel, std::size_t most = ~std::size_t{0});

private:
    struct Piece {
        std::shared_ptr<const void> owner;
        std::string_view bytes;
        bool copied;
    };
    std::deque<Piece> pieces_;
    std::size_t copied_ = 0;
    std::uint64_t sent_ = 0;
};

}  // namespace rivage::server
