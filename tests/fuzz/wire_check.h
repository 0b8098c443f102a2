#pragma once

#include "proto/json.h"
#include "tests/fuzz/check.h"

namespace rivage::fuzz {

/// As `requireGoodError`, for errors that repeat what a client sent, which may be no UTF-8: the
/// wire must repair it.
inline void requireGoodWireError(const core::Error& error) {
    require(!error.message.empty());
    require(error.code != core::ErrorCode::internal);
    const std::string text = proto::writeJson({error.message, error.field});
    require(proto::readJson(text, "", {.maxBytes = 1 << 20}).has_value());
}

}  // namespace rivage::fuzz
