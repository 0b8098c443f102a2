#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "client/sha256.h"
#include "client/transport.h"

namespace rivage::client {

/// Where the bytes of a result are kept until it is whole.
struct ByteStore {
    std::function<bool()> restart;                ///< drops what came; false if that cannot be
    std::function<bool(std::string_view)> write;  ///< false: cannot be kept
};

/// Puts one representation together from as many answers as it takes: what came stays, the rest is
/// asked for with Range and If-Range. Another entity tag, or a server without ranges, starts over.
class ResumedBody : public BodySink {
public:
    explicit ResumedBody(const ByteStore& store) : store_(store) {}

    void prepare(httplib::Request& request) override;
    bool begin(const httplib::Response& head) override;
    bool write(std::string_view bytes) override;
    bool restart() override;
    [[nodiscard]] std::uint64_t received() const override { return received_; }

    /// Whether the bytes are those that `Repr-Digest` promises.
    [[nodiscard]] bool intact() const;

private:
    const ByteStore& store_;
    Sha256 digest_;
    std::string etag_;      ///< strong, or empty
    std::string promised_;  ///< Repr-Digest
    std::uint64_t received_ = 0;
    bool stray_ = false;  ///< the last answer brought a part that was not asked for
};

/// Fetches a whole representation. One that arrives damaged is fetched anew, once.
/// @errors  what Transport::send has; unreachable if it arrives damaged twice; failed if the answer
///          is none of 200 and 206
Outcome<void> download(Transport& transport, const std::string& path, const ByteStore& store,
                       bool patient = false);

}  // namespace rivage::client
