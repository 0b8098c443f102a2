#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace rivage::server {

/// What an open connection is doing.
enum class Phase : std::uint8_t {
    header,   ///< TLS handshake, or a request head that is not complete
    body,     ///< a handler waits for bytes of the body
    handler,  ///< a request is being answered, or waits for a thread
    idle,     ///< between requests
    stream,   ///< an answer is on its way out
    closing,  ///< the last answer is sent; the client has not closed yet
};
inline constexpr std::array<std::string_view, 6> kPhaseNames{"header", "body",   "handler",
                                                             "idle",   "stream", "closing"};

/// What connections do and did; any thread may read it at any time.
struct NetStats {
    std::array<std::atomic<std::size_t>, kPhaseNames.size()> open{};  ///< by `Phase`
    std::atomic<std::size_t> activeRequests{0};                       ///< in a handler thread
    std::atomic<std::uint64_t> accepted{0};                           ///< connections
    std::atomic<std::uint64_t> requests{0};                           ///< answered by handlers
    std::atomic<std::uint64_t> refused{0};   ///< answered without a handler: 4xx and 503
    std::atomic<std::uint64_t> timedOut{0};  ///< connections that were too slow for a limit

    [[nodiscard]] std::size_t count(Phase phase) const {
        return open[static_cast<std::size_t>(phase)];
    }
};

/// Counts one connection in the phase that it is in.
class PhaseMark {
public:
    explicit PhaseMark(NetStats& stats) : stats_(stats) { ++of(phase_); }
    ~PhaseMark() { --of(phase_); }
    PhaseMark(const PhaseMark&) = delete;
    PhaseMark& operator=(const PhaseMark&) = delete;

    void enter(Phase phase) {
        if (phase == phase_) return;
        ++of(phase);
        --of(phase_);
        phase_ = phase;
    }

private:
    std::atomic<std::size_t>& of(Phase phase) {
        return stats_.open[static_cast<std::size_t>(phase)];
    }
    NetStats& stats_;
    Phase phase_ = Phase::header;
};

}  // namespace rivage::server
