#pragma once

#include <chrono>
#include <cstddef>
#include <string>

#include "client/failure.h"
#include "client/interrupt.h"

namespace rivage::client::load {

/// What a file may be at most.
struct InputBounds {
    std::size_t bytes = std::size_t{16} << 20;
    std::chrono::milliseconds time{30'000};  ///< until the end of a pipe
};

/// Reads a file that the user names, or a pipe, as the shell makes it of `<(...)`. Devices and
/// folders are refused: they have no end, or no bytes.
/// @param what  what it is to be, for messages: "mix"
/// @errors usage if it cannot be read, is too large or does not end in time; cancelled
Outcome<std::string> readInput(const std::string& what, const std::string& path,
                               const InputBounds& bounds, const Interrupt& interrupt);

}  // namespace rivage::client::load
