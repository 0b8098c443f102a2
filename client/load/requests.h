#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "client/interrupt.h"
#include "client/load/mix.h"
#include "client/load/target.h"

namespace rivage::client::load {

/// Writes heads of requests to one server.
class HeadWriter {
public:
    HeadWriter(std::string host, const std::string& apiKey);
    /// @param fields  more lines, each with its end
    [[nodiscard]] std::string write(std::string_view method, std::string_view path,
                                    std::string_view fields = {}) const;
    [[nodiscard]] std::string write(std::string_view method, std::string_view path,
                                    std::string_view fields, std::size_t bodySize) const;

private:
    std::string common_;
};

/// The requests of one entry of a mix, ready to be sent again and again.
struct PreparedEntry {
    MixEntry entry;
    std::string fresh;  ///< the head; of a conversion one that wants no kept result
    std::string kept;   ///< the same, but a kept result is welcome
    std::string body;
};

/// Everything that a generator sends.
struct PreparedMix {
    Mix mix;
    std::vector<PreparedEntry> entries;
    HeadWriter heads;
};

/// Reads the files of a mix, fetches its samples, and writes the requests.
/// @errors usage if a file cannot be read; what Transport::send has for a sample
Outcome<PreparedMix> prepareMix(const Mix& mix, const ServerAccess& server, const Target& target,
                                Interrupt& interrupt);

}  // namespace rivage::client::load
