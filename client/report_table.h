#pragma once

#include <string>

#include "proto/json.h"

namespace rivage::client {

/// The report of a conversion as lines for a person; members that are missing are left out.
[[nodiscard]] std::string reportTable(const proto::Json& report);

/// The answer of POST /v1/inspect as lines for a person.
[[nodiscard]] std::string inspectionTable(const proto::Json& inspection);

/// The answer of GET /v1/options as lines for a person.
[[nodiscard]] std::string optionTable(const proto::Json& answer);

}  // namespace rivage::client
