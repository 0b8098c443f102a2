#include "server/http/form_parser.h"

#include <algorithm>
#include <utility>

#include "server/http/text.h"

namespace rivage::server {
namespace {

constexpr std::size_t kMaxHeadLine = 8 << 10;
constexpr std::size_t kMaxHeadLines = 16;
constexpr std::size_t kMaxIgnored = 4 << 10;
/// Bodies are taken in pieces of this size, so that the buffer stays small.
constexpr std::size_t kPieceBytes = 16 << 10;

/// Takes `name=value` or `name="value"` off a list of parameters that begins with ';'.
/// @return false at the end, or if it is malformed: then `list` is not empty
bool takeParameter(std::string_view& list, std::string& name, std::string& value) {
    list = trimmed(list);
    if (!list.starts_with(';')) return false;
    list.remove_prefix(1);
    const std::size_t equals = list.find('=');
    if (equals == std::string_view::npos) return false;
    name = lowerCase(trimmed(list.substr(0, equals)));
    list = trimmed(list.substr(equals + 1));
    value.clear();
    if (!list.starts_with('"')) {
        const std::size_t end = std::min(list.find(';'), list.size());
        value = std::string(trimmed(list.substr(0, end)));
        list.remove_prefix(end);
        return true;
    }
    for (std::size_t i = 1; i < list.size(); ++i) {
        if (list[i] == '"') {
            list.remove_prefix(i + 1);
            return true;
        }
        if (list[i] == '\\' && i + 1 < list.size() && (list[i + 1] == '"' || list[i + 1] == '\\'))
            ++i;
        value += list[i];
    }
    return false;
}

bool isBoundary(std::string_view text) {
    constexpr std::string_view kOthers = "'()+_,-./:=? ";
    return !text.empty() && text.size() <= 70 && text.back() != ' ' &&
           std::all_of(text.begin(), text.end(), [&](unsigned char c) {
               return std::isalnum(c) != 0 ||
                      kOthers.find(static_cast<char>(c)) != std::string_view::npos;
           });
}

}  // namespace

std::optional<std::string> formBoundary(std::string_view contentType) {
    const std::size_t end = std::min(contentType.find(';'), contentType.size());
    if (lowerCase(trimmed(contentType.substr(0, end))) != "multipart/form-data")
        return std::nullopt;
    contentType.remove_prefix(end);
    std::string name;
    std::string value;
    while (takeParameter(contentType, name, value))
        if (name == "boundary") return isBoundary(value) ? value : std::string();
    return std::string();
}

std::string fileNameOf(std::string_view disposition) {
    disposition.remove_prefix(std::min(disposition.find(';'), disposition.size()));
    std::string name;
    std::string value;
    while (takeParameter(disposition, name, value))
        if (name == "filename") return value;
    return {};
}

FormParser::FormParser(const std::string& boundary, Begin begin, Take take)
    : delimiter_("\r\n--" + boundary),
      begin_(std::move(begin)),
      take_(std::move(take)),
      buffer_("\r\n") {}  // so that the first boundary looks like every other

bool FormParser::parse(const char* data, std::size_t size) {
    while (size > 0) {
        const std::size_t piece = std::min(size, kPieceBytes);
        buffer_.append(data, piece);
        data += piece;
        size -= piece;
        for (bool progress = true; progress;) {
            progress = false;
            if (!step(progress)) return false;
        }
    }
    return true;
}

bool FormParser::step(bool& progress) {
    switch (state_) {
        case State::preamble: return readPreamble(progress);
        case State::afterBoundary: return readAfterBoundary(progress);
        case State::head: return readHead(progress);
        case State::body: return readBody(progress);
        case State::epilogue: return readEpilogue();
    }
    return false;
}

bool FormParser::readPreamble(bool& progress) {
    // Line ends before the first boundary are taken; the last one belongs to it.
    while (buffer_.starts_with("\r\n\r\n")) {
        buffer_.erase(0, 2);
        if ((ignored_ += 2) > kMaxIgnored) return false;
    }
    const std::size_t seen = std::min(buffer_.size(), delimiter_.size());
    const bool lineEnds = buffer_ == "\r\n\r";
    if (!lineEnds && buffer_.compare(0, seen, delimiter_, 0, seen) != 0) return false;
    if (lineEnds || seen < delimiter_.size()) return true;
    buffer_.erase(0, delimiter_.size());
    state_ = State::afterBoundary;
    return progress = true;
}

bool FormParser::readAfterBoundary(bool& progress) {
    if (buffer_.size() < 2) return true;
    const bool last = buffer_.starts_with("--");
    if (!last && !buffer_.starts_with("\r\n")) return false;
    buffer_.erase(0, 2);
    state_ = last ? State::epilogue : State::head;
    ignored_ = 0;
    lines_ = 0;
    named_ = false;
    part_ = {};
    return progress = true;
}

bool FormParser::readHead(bool& progress) {
    const std::size_t end = buffer_.find("\r\n");
    if (end == std::string::npos) return buffer_.size() <= kMaxHeadLine;
    if (end > kMaxHeadLine) return false;
    progress = true;
    if (end == 0) {
        buffer_.erase(0, 2);
        state_ = State::body;
        return named_ && begin_(part_);
    }
    const std::string line = buffer_.substr(0, end);
    buffer_.erase(0, end + 2);
    return ++lines_ <= kMaxHeadLines && readHeadLine(line);
}

bool FormParser::readHeadLine(std::string_view line) {
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos || colon == 0) return false;
    if (lowerCase(line.substr(0, colon)) != "content-disposition") return true;
    std::string_view value = trimmed(line.substr(colon + 1));
    const std::size_t end = std::min(value.find(';'), value.size());
    if (std::exchange(named_, true) || lowerCase(trimmed(value.substr(0, end))) != "form-data")
        return false;
    value.remove_prefix(end);
    std::string name;
    std::string text;
    bool found = false;
    while (takeParameter(value, name, text)) {
        if (name == "name" && !std::exchange(found, true)) part_.name = text;
        if (name == "filename") part_.filename = text;
    }
    return found && value.empty();
}

bool FormParser::readBody(bool& progress) {
    const std::size_t at = buffer_.find(delimiter_);
    if (at != std::string::npos) {
        if (at > 0 && !take_(buffer_.data(), at)) return false;
        buffer_.erase(0, at + delimiter_.size());
        state_ = State::afterBoundary;
        return progress = true;
    }
    if (buffer_.size() < delimiter_.size()) return true;
    const std::size_t sure = buffer_.size() - delimiter_.size() + 1;
    if (!take_(buffer_.data(), sure)) return false;
    buffer_.erase(0, sure);
    return true;
}

bool FormParser::readEpilogue() {
    ignored_ += buffer_.size();
    buffer_.clear();
    return ignored_ <= kMaxIgnored;
}

}  // namespace rivage::server
