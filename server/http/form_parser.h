#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace rivage::server {

/// What the head of a part says.
struct FormPart {
    std::string name;
    std::string filename;
};

/// The boundary of `multipart/form-data; boundary=...`; nothing if the media type is another one.
/// An empty text if the boundary is missing or not 1 to 70 characters that RFC 2046 allows.
[[nodiscard]] std::optional<std::string> formBoundary(std::string_view contentType);

/// The file name in a Content-Disposition, as it stands there; empty if there is none.
[[nodiscard]] std::string fileNameOf(std::string_view disposition);

/// Reads multipart/form-data piece by piece. Holds at most one head of a part (8 KiB, 16 lines) and
/// a line of its boundary, whatever comes; nothing may stand before the first part but line ends,
/// and nothing after the last one but 4 KiB that are ignored. Linear in the bytes.
class FormParser {
public:
    using Begin = std::function<bool(const FormPart& part)>;
    using Take = std::function<bool(const char* data, std::size_t size)>;

    FormParser(const std::string& boundary, Begin begin, Take take);
    /// @return false if the form is broken, or as soon as a callback says no
    bool parse(const char* data, std::size_t size);
    /// Whether the closing boundary was there.
    [[nodiscard]] bool complete() const { return state_ == State::epilogue; }

private:
    enum class State : std::uint8_t { preamble, afterBoundary, head, body, epilogue };
    bool step(bool& progress);
    bool readPreamble(bool& progress);
    bool readAfterBoundary(bool& progress);
    bool readHead(bool& progress);
    bool readBody(bool& progress);
    bool readEpilogue();
    bool readHeadLine(std::string_view line);

    const std::string delimiter_;  ///< CRLF "--" boundary
    const Begin begin_;
    const Take take_;
    State state_ = State::preamble;
    std::string buffer_;
    FormPart part_;
    bool named_ = false;
    std::size_t lines_ = 0;
    std::size_t ignored_ = 0;
};

}  // namespace rivage::server
