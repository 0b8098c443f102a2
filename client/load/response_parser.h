#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace rivage::client::load {

/// What is kept of the body of an answer.
enum class Keep : std::uint8_t {
    nothing,
    errors,  ///< those with a status of 400 and more: they tell their problem
    all,
};

/// Reads one answer of HTTP/1.1 as it arrives, in pieces of any size: with a length, in chunks, or
/// up to the end of the connection. Interim answers (1xx) are passed over.
class ResponseParser {
public:
    static constexpr std::size_t kMaxHead = 64 << 10;
    static constexpr std::size_t kMaxKept = 256 << 20;

    /// @param bodiless  the answer is to HEAD: it has no body, whatever it says
    void reset(Keep keep, bool bodiless = false);

    /// Takes bytes; stops at the end of the answer.
    /// @return how many were taken
    std::size_t feed(std::string_view bytes);
    /// The connection has ended. @return whether the answer is whole
    bool finish();

    [[nodiscard]] bool done() const { return state_ == State::done; }
    /// This is no answer of HTTP/1.1.
    [[nodiscard]] bool malformed() const { return state_ == State::malformed; }
    /// The connection may be used again.
    [[nodiscard]] bool reusable() const { return done() && keepAlive_; }
    /// 0 before the head is complete.
    [[nodiscard]] int status() const { return headDone_ ? status_ : 0; }
    /// The value of a field, without blanks around it; empty if there is none.
    [[nodiscard]] std::string_view field(std::string_view name) const;
    [[nodiscard]] std::uint64_t bodySize() const { return bodySize_; }
    [[nodiscard]] const std::string& body() const { return body_; }
    [[nodiscard]] std::string takeBody() { return std::move(body_); }
    [[nodiscard]] const std::string& head() const { return head_; }

private:
    enum class State : std::uint8_t {
        head,
        length,
        chunkSize,
        chunk,
        chunkEnd,
        trailer,
        untilClose,
        done,
        malformed,
    };
    std::size_t feedHead(std::string_view bytes);
    std::size_t feedLine(std::string_view bytes);
    std::size_t feedBody(std::string_view bytes);
    void endHead();
    void endLine();
    bool readStatusLine(std::string_view line);
    bool readField(std::string_view line);
    void chooseBody();
    void keep(std::string_view piece);

    State state_ = State::head;
    Keep keep_ = Keep::nothing;
    bool bodiless_ = false;
    bool headDone_ = false;
    bool keepAlive_ = true;
    bool chunked_ = false;
    int status_ = 0;
    std::optional<std::uint64_t> length_;
    std::uint64_t left_ = 0;  ///< bytes of the body or the chunk that are still to come
    std::uint64_t bodySize_ = 0;
    std::string head_;
    std::string line_;  ///< of a chunk size or a trailer, as far as it has come
    std::string body_;
};

/// Whether two names of fields are the same.
[[nodiscard]] bool sameName(std::string_view a, std::string_view b);

}  // namespace rivage::client::load
