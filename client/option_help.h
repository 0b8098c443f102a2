#pragma once

#include <string>

#include "client/failure.h"

namespace rivage::client {

/// What `rivage options NAME` tells: as JSON, and as lines for a person.
struct OptionHelp {
    proto::Json json;
    std::string text;
};

/// Explains one option, as it is written on the wire or on the command line, or one preset.
/// @param answer  of the server, to GET /v1/options
/// @errors usage if there is neither
[[nodiscard]] Outcome<OptionHelp> explainOption(const proto::Json& answer, std::string name);

}  // namespace rivage::client
