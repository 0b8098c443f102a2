#include <string_view>
#include <vector>

#include "proto/options.h"
#include "tests/fuzz/wire_check.h"

using namespace rivage;

namespace {

/// "name=value&name=value" as the server gets it from a query, without percent signs.
std::vector<proto::OptionText> splitQuery(std::string_view query) {
    std::vector<proto::OptionText> options;
    while (!query.empty()) {
        const std::string_view item = query.substr(0, query.find('&'));
        query.remove_prefix(std::min(item.size() + 1, query.size()));
        const std::size_t equals = std::min(item.find('='), item.size());
        options.push_back({std::string(item.substr(0, equals)),
                           std::string(item.substr(std::min(equals + 1, item.size())))});
    }
    return options;
}

}  // namespace

/// The first byte chooses between JSON, a query, and both (divided by the first line feed). What
/// is accepted is echoed, and the echo is accepted with the same meaning.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
    const int kind = data[0] % 3;
    const std::size_t line = kind == 2 ? std::min(text.find('\n'), text.size()) : 0;
    const std::string_view query = kind == 1 ? text : text.substr(0, line);
    const std::string_view json = kind == 1 ? std::string_view{} : text.substr(line);
    const auto options = proto::parseOptions(splitQuery(query), json);
    if (!options) {
        fuzz::requireGoodWireError(options.error());
        return 0;
    }
    const std::string echo = proto::writeJson(proto::toJson(options->conversion));
    const auto again = proto::parseOptions({}, echo);
    fuzz::require(again && proto::writeJson(proto::toJson(again->conversion)) == echo);
    return 0;
}
