#include "server/net/head_scanner.h"

#include <algorithm>

namespace rivage::server {
namespace {

bool isField(std::string_view line, std::string_view lowerName) {
    if (line.size() <= lowerName.size() || line[lowerName.size()] != ':') return false;
    return std::equal(lowerName.begin(), lowerName.end(), line.begin(), [](char lower, char c) {
        return lower == (c >= 'A' && c <= 'Z' ? static_cast<char>(c | 0x20) : c);
    });
}

/// Whether the value of a line "name: value CRLF" is a number, which no parser reads in another way.
bool isNumber(std::string_view line) {
    line.remove_prefix(line.find(':') + 1);
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
    while (!line.empty() && blank(line.front())) line.remove_prefix(1);
    while (!line.empty() && blank(line.back())) line.remove_suffix(1);
    return !line.empty() && line.size() < 19 &&
           std::all_of(line.begin(), line.end(), [](char c) { return c >= '0' && c <= '9'; });
}

bool isForbidden(char c) {
    const auto code = static_cast<unsigned char>(c);
    return (code < 0x20 && c != '\t' && c != '\r' && c != '\n') || code == 0x7f;
}

}  // namespace

/// Whether the bytes up to `c` cannot begin a head.
int HeadScanner::refusal(std::string_view bytes, char previous, char c) const {
    const bool first = at_ == lineStart_;
    const bool folded = first && lines_ > 0 && (c == ' ' || c == '\t');
    const bool noMethod = first && lines_ == 0 && (c < 'A' || c > 'Z');
    const bool brokenEnd = (c == '\n') != (!bytes.empty() && previous == '\r');
    return isForbidden(c) || folded || noMethod || brokenEnd ? 400 : 0;
}

/// @return false if the line is no request line, or says again, or not clearly, whom the request is
///         for or how long its body is
bool HeadScanner::endLine(std::string_view line) {
    if (lines_++ == 0) {
        old_ = line.ends_with(" HTTP/1.0\r\n");
        return std::count(line.begin(), line.end(), ' ') == 2;
    }
    if (isField(line, "host")) return ++hosts_ == 1;
    if (isField(line, "transfer-encoding") && line.find(',') != std::string_view::npos)
        return false;
    const bool length = isField(line, "content-length");
    if (length || isField(line, "transfer-encoding")) ++framings_;
    return framings_ <= 1 && (!length || isNumber(line));
}

HeadVerdict HeadScanner::scan(std::string_view bytes, const NetLimits& limits) {
    while (at_ < bytes.size()) {
        const char c = bytes[at_];
        if (const int status = refusal(bytes, at_ > 0 ? bytes[at_ - 1] : '\0', c))
            return {false, status, 0};
        ++at_;
        const std::size_t length = at_ - lineStart_;
        if (length > limits.lineBytes) return {false, lines_ == 0 ? 414 : 431, limits.lineBytes};
        if (at_ > limits.headBytes) return {false, 431, limits.headBytes};
        if (c != '\n') continue;
        if (length == 2 && hosts_ == 0 && !old_) return {false, 400, 0};
        if (length == 2) return {true, 0, 0};
        if (!endLine(bytes.substr(lineStart_, length))) return {false, 400, 0};
        lineStart_ = at_;
        if (lines_ > limits.headers + 1) return {false, 431, limits.headers};
    }
    return {};
}

}  // namespace rivage::server
