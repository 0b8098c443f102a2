#pragma once

#include "client/reference/reference.h"

namespace rivage::client {

/// What the man page of `rivage` says beside its options.
[[nodiscard]] ManPageText manualText();

}  // namespace rivage::client
