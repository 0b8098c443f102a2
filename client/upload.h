#pragma once

#include <httplib.h>

#include <string>
#include <vector>

#include "proto/options.h"

namespace rivage::client {

/// A grid to send, with the options that were given for it.
struct Upload {
    std::string bytes;
    std::vector<proto::OptionText> options;  ///< valid: `proto::parseOptions` accepts them
    std::string name = {};                   ///< of the file; empty where none is to be told
};

/// The request that posts a grid: as the raw body with the options in the query, or, where the
/// query would be too long for a request line, as multipart/form-data.
[[nodiscard]] httplib::Request makeUpload(const std::string& path, const Upload& upload);

/// A random key of 32 hexadecimal digits.
[[nodiscard]] std::string randomKey();

}  // namespace rivage::client
