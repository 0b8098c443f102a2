#include "client/load/response_parser.h"

#include <algorithm>
#include <charconv>

namespace rivage::client::load {
namespace {

constexpr std::size_t kMaxLine = 4096;  // of a chunk size or a trailer

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

std::string_view trimmed(std::string_view text) {
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

std::optional<std::uint64_t> readNumber(std::string_view text, int base) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    if (text.empty() || error != std::errc() || end != text.data() + text.size())
        return std::nullopt;
    return value;
}

/// Whether a list of words names `word`.
bool names(std::string_view list, std::string_view word) {
    while (!list.empty()) {
        const std::size_t comma = std::min(list.find(','), list.size());
        if (sameName(trimmed(list.substr(0, comma)), word)) return true;
        list.remove_prefix(std::min(comma + 1, list.size()));
    }
    return false;
}

/// Takes the line before the next line feed off `text`.
std::string_view takeLine(std::string_view& text) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
}

}  // namespace

bool sameName(std::string_view a, std::string_view b) {
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(),
                                              [](char x, char y) { return lower(x) == lower(y); });
}

void ResponseParser::reset(Keep keep, bool bodiless) {
    state_ = State::head;
    keep_ = keep;
    bodiless_ = bodiless;
    headDone_ = false;
    status_ = 0;
    left_ = 0;
    bodySize_ = 0;
    head_.clear();
    line_.clear();
    body_.clear();
}

std::size_t ResponseParser::feed(std::string_view bytes) {
    std::size_t used = 0;
    while (used < bytes.size() && state_ != State::done && state_ != State::malformed) {
        const std::string_view rest = bytes.substr(used);
        if (state_ == State::head)
            used += feedHead(rest);
        else if (state_ == State::length || state_ == State::chunk || state_ == State::untilClose)
            used += feedBody(rest);
        else
            used += feedLine(rest);
    }
    return used;
}

bool ResponseParser::finish() {
    if (state_ == State::untilClose) state_ = State::done;
    keepAlive_ = false;
    return done();
}

std::size_t ResponseParser::feedHead(std::string_view bytes) {
    // The empty line may lie across two pieces.
    const std::size_t before = head_.size();
    const std::size_t from = before < 3 ? 0 : before - 3;
    const std::size_t taken = std::min(bytes.size(), kMaxHead - before);
    head_.append(bytes.substr(0, taken));
    const std::size_t end = head_.find("\r\n\r\n", from);
    if (end == std::string::npos) {
        if (head_.size() >= kMaxHead) state_ = State::malformed;
        return taken;
    }
    head_.resize(end + 4);
    endHead();
    return end + 4 - before;
}

void ResponseParser::endHead() {
    keepAlive_ = true;
    chunked_ = false;
    length_.reset();
    std::string_view rest = head_;
    if (!readStatusLine(takeLine(rest))) {
        state_ = State::malformed;
        return;
    }
    for (std::string_view line = takeLine(rest); !line.empty(); line = takeLine(rest)) {
        if (readField(line)) continue;
        state_ = State::malformed;
        return;
    }
    if (status_ < 200 && status_ != 101) {
        left_ += head_.size();  // counts interim answers until the body has a length
        if (left_ > kMaxHead) state_ = State::malformed;
        head_.clear();
        return;
    }
    headDone_ = true;
    chooseBody();
}

bool ResponseParser::readStatusLine(std::string_view line) {
    if (!line.starts_with("HTTP/1.") || line.size() < 12 || line[8] != ' ') return false;
    if (line[7] == '0') keepAlive_ = false;
    const auto status = readNumber(line.substr(9, 3), 10);
    if (!status || *status < 100 || *status > 599 || (line.size() > 12 && line[12] != ' '))
        return false;
    status_ = static_cast<int>(*status);
    return true;
}

bool ResponseParser::readField(std::string_view line) {
    const std::size_t colon = line.find(':');
    if (colon == 0 || colon == std::string_view::npos) return false;
    const std::string_view name = line.substr(0, colon);
    const std::string_view value = trimmed(line.substr(colon + 1));
    if (sameName(name, "content-length")) {
        const auto length = readNumber(value, 10);
        if (!length || (length_ && *length_ != *length)) return false;
        length_ = length;
    } else if (sameName(name, "transfer-encoding")) {
        if (!names(value, "chunked")) return false;
        chunked_ = true;
    } else if (sameName(name, "connection")) {
        if (names(value, "close")) keepAlive_ = false;
        if (names(value, "keep-alive")) keepAlive_ = true;
    }
    return true;
}

void ResponseParser::chooseBody() {
    if (bodiless_ || status_ == 204 || status_ == 304) {
        state_ = State::done;
    } else if (chunked_) {
        state_ = State::chunkSize;
    } else if (length_) {
        left_ = *length_;
        state_ = left_ == 0 ? State::done : State::length;
    } else {
        keepAlive_ = false;
        state_ = State::untilClose;
    }
}

std::size_t ResponseParser::feedBody(std::string_view bytes) {
    const bool counted = state_ != State::untilClose;
    const std::size_t taken =
        counted ? static_cast<std::size_t>(std::min<std::uint64_t>(left_, bytes.size()))
                : bytes.size();
    keep(bytes.substr(0, taken));
    if (!counted) return taken;
    left_ -= taken;
    if (left_ == 0) state_ = state_ == State::chunk ? State::chunkEnd : State::done;
    return taken;
}

std::size_t ResponseParser::feedLine(std::string_view bytes) {
    const std::size_t end = bytes.find('\n');
    line_.append(bytes.substr(0, end));
    if (line_.size() > kMaxLine) {
        state_ = State::malformed;
        return bytes.size();
    }
    if (end == std::string_view::npos) return bytes.size();
    if (line_.ends_with('\r')) line_.pop_back();
    endLine();
    line_.clear();
    return end + 1;
}

void ResponseParser::endLine() {
    if (state_ == State::chunkEnd) {
        state_ = line_.empty() ? State::chunkSize : State::malformed;
    } else if (state_ == State::trailer) {
        left_ += line_.size() + 2;  // no chunk is left: counts the trailer
        if (line_.empty() || left_ > kMaxHead)
            state_ = line_.empty() ? State::done : State::malformed;
    } else {
        const auto size =
            readNumber(trimmed(std::string_view(line_).substr(0, line_.find(';'))), 16);
        left_ = size.value_or(0);
        state_ = !size ? State::malformed : left_ == 0 ? State::trailer : State::chunk;
    }
}

void ResponseParser::keep(std::string_view piece) {
    bodySize_ += piece.size();
    const bool wanted = keep_ == Keep::all || (keep_ == Keep::errors && status_ >= 400);
    if (wanted && body_.size() + piece.size() <= kMaxKept) body_.append(piece);
}

std::string_view ResponseParser::field(std::string_view name) const {
    std::string_view rest = head_;
    takeLine(rest);
    for (std::string_view line = takeLine(rest); !line.empty(); line = takeLine(rest)) {
        const std::size_t colon = line.find(':');
        if (colon != std::string_view::npos && sameName(line.substr(0, colon), name))
            return trimmed(line.substr(colon + 1));
    }
    return {};
}

}  // namespace rivage::client::load
