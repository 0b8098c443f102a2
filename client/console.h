#pragma once

#include <cstdint>
#include <istream>
#include <ostream>
#include <string>

namespace rivage::client {

/// Where a run reads and writes: results and JSON go to `out`, words to `err`.
struct Console {
    std::istream& in;
    std::ostream& out;
    std::ostream& err;
    bool outIsTerminal = false;
    bool errIsTerminal = false;  ///< one that understands escape sequences
    int width = 80;              ///< columns of the terminal behind `err`
    int height = 24;             ///< its lines
    bool color = false;          ///< words on `err` may be coloured
    int inFile = -1;             ///< of `in`, where a stop has to end the reading; -1: has none
};

/// Whether everything that `out` was given has arrived: a full disk or a closed pipe may only show
/// now. If not, it is said on `err`.
/// @param program  its name, for the complaint
[[nodiscard]] inline bool outputArrived(Console& console, const char* program) {
    if (console.out.flush()) return true;
    console.err << program << ": stdout cannot be written\n" << std::flush;
    return false;
}

enum class Tone : std::uint8_t { good, bad, dim };

/// The text in a colour, if the console shows any.
[[nodiscard]] inline std::string painted(const Console& console, Tone tone,
                                         const std::string& text) {
    if (!console.color) return text;
    const char* const code = tone == Tone::good ? "32" : tone == Tone::bad ? "31" : "2";
    return std::string("\x1b[") + code + "m" + text + "\x1b[0m";
}

}  // namespace rivage::client
