#include "proto/json.h"

#include <utility>
#include <vector>

namespace rivage::proto {
namespace {

using core::ErrorCode;
using core::fail;

/// Builds the value while the parser reports it, and refuses at the first thing not wanted.
class Builder final : public nlohmann::json_sax<Json> {
public:
    explicit Builder(const JsonLimits& limits) : limits_(limits) {}

    [[nodiscard]] Json take() { return std::move(root_); }
    [[nodiscard]] const std::string& problem() const { return problem_; }

    bool null() override { return add(nullptr); }
    bool boolean(bool value) override { return add(value); }
    bool number_integer(number_integer_t value) override { return add(value); }
    bool number_unsigned(number_unsigned_t value) override { return add(value); }
    bool number_float(number_float_t value, const string_t&) override { return add(value); }
    bool string(string_t& value) override { return add(std::move(value)); }
    bool binary(binary_t&) override { return refuse("binary values are not JSON"); }

    bool start_object(std::size_t) override { return open(Json::object()); }
    bool start_array(std::size_t) override { return open(Json::array()); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }

    bool key(string_t& name) override {
        const Json& object = *open_.back();
        if (object.size() >= limits_.maxMembers)
            return refuse("an object has more than " + std::to_string(limits_.maxMembers) +
                          " members");
        if (object.contains(name)) return refuse("the member " + inQuotes(name) + " occurs twice");
        key_ = std::move(name);
        return true;
    }

    bool parse_error(std::size_t position, const std::string&,
                     const nlohmann::detail::exception& error) override {
        if (error.id == 406) return refuse("a number is too large");
        return refuse("it is not JSON from byte " + std::to_string(position) + " on");
    }

private:
    bool refuse(std::string problem) {
        if (problem_.empty()) problem_ = std::move(problem);
        return false;
    }

    Json* place(Json value) {
        if (open_.empty()) {
            root_ = std::move(value);
            return &root_;
        }
        Json& parent = *open_.back();
        if (parent.is_array()) {
            parent.push_back(std::move(value));
            return &parent.back();
        }
        Json& member = parent[key_];
        member = std::move(value);
        return &member;
    }

    bool add(Json value) {
        place(std::move(value));
        return true;
    }

    bool open(Json value) {
        if (open_.size() >= limits_.maxDepth)
            return refuse("it is nested deeper than " + std::to_string(limits_.maxDepth));
        open_.push_back(place(std::move(value)));
        return true;
    }

    bool close() {
        open_.pop_back();
        return true;
    }

    const JsonLimits& limits_;
    Json root_;
    std::vector<Json*> open_;  ///< a parent does not grow while one of its children is open
    std::string key_;
    std::string problem_;
};

}  // namespace

core::Result<Json> readJson(std::string_view text, const std::string& field,
                            const JsonLimits& limits) {
    if (text.size() > limits.maxBytes) {
        core::Error error{ErrorCode::malformedRequest, "the JSON text is too long", field};
        error.limit = limits.maxBytes;
        error.actual = text.size();
        return fail(std::move(error));
    }
    Builder builder(limits);
    if (!Json::sax_parse(text, &builder))
        return fail(ErrorCode::malformedRequest, "the JSON text is refused: " + builder.problem(),
                    field);
    return builder.take();
}

std::string writeJson(const Json& value) {
    return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string inQuotes(std::string_view text) {
    constexpr std::size_t kShown = 64;
    std::string result = "\"";
    for (const char c : text.substr(0, kShown))
        result += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
    result += text.size() > kShown ? "...\"" : "\"";
    return result;
}

}  // namespace rivage::proto
