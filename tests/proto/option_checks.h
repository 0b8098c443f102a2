#pragma once

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "proto/options.h"

/// What the tests of options share.
namespace rivage::test {

inline core::Result<proto::JobOptions> parse(const std::vector<proto::OptionText>& text,
                                             const std::string& json = {}) {
    return proto::parseOptions(text, json);
}

inline void checkRefused(const core::Result<proto::JobOptions>& options, core::ErrorCode code,
                         const std::string& field) {
    REQUIRE_FALSE(options);
    CHECK(options.error().code == code);
    CHECK(options.error().field == field);
    CHECK_FALSE(options.error().message.empty());
}

/// An option as it is in force, null where it is not.
inline proto::Json valueOf(const proto::JobOptions& options, const std::string& name) {
    const proto::Json json = proto::toJson(options);
    return json.contains(name) ? json[name] : proto::Json();
}

}  // namespace rivage::test
