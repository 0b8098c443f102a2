#pragma once

#include <iosfwd>
#include <istream>
#include <ostream>

namespace rivage::client {

/// Where a run reads and writes: results and JSON go to `out`, words to `err`.
struct Console {
    std::istream& in;
    std::ostream& out;
    std::ostream& err;
    bool outIsTerminal = false;
    bool errIsTerminal = false;
    int width = 80;  ///< columns of the terminal behind `err`
};

}  // namespace rivage::client
