#pragma once

#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "proto/option_table.h"

/// Makes the options of the common kinds. `reference` gives the field of the options that an option
/// sets, e.g. `[](ConversionOptions& o) -> double& { return o.method.energy.alpha; }`. Internal to
/// the option table.
namespace rivage::proto {

using core::ConversionOptions;

/// The option, without effect but where `applies`; `condition` says where that is.
[[nodiscard]] inline Option onlyWith(std::string condition, Option option,
                                     std::function<bool(const ConversionOptions&)> applies) {
    option.info.onlyWith = std::move(condition);
    option.applies = [applies = std::move(applies)](const JobOptions& options) {
        return applies(options.conversion);
    };
    return option;
}

/// An enumeration whose enumerators are numbered as `words` are.
template <typename Reference>
[[nodiscard]] Option choice(std::string name, std::string group, std::vector<std::string> words,
                            std::string sentence, Reference reference) {
    Option option;
    option.set = [reference](JobOptions& options, const OptionValue& value) {
        auto& target = reference(options.conversion);
        target = static_cast<std::decay_t<decltype(target)>>(std::get<Word>(value).index);
    };
    option.get = [reference, words](const JobOptions& options) -> Json {
        ConversionOptions copy = options.conversion;
        return words[static_cast<std::size_t>(reference(copy))];
    };
    option.info = {std::move(name),    std::move(group), OptionType::choice, std::move(words), 0, 0,
                   std::move(sentence)};
    return option;
}

template <typename Reference>
[[nodiscard]] Option flag(std::string name, std::string group, std::string sentence,
                          Reference reference) {
    return {{std::move(name), std::move(group), OptionType::flag, {}, 0, 0, std::move(sentence)},
            [reference](JobOptions& options, const OptionValue& value) {
                reference(options.conversion) = std::get<bool>(value);
            },
            [reference](const JobOptions& options) -> Json {
                ConversionOptions copy = options.conversion;
                return reference(copy);
            }};
}

struct Range {
    double minimum = 0;
    double maximum = 0;
};

/// A number; the type behind `reference` decides whether it is an integer.
template <typename Reference>
[[nodiscard]] Option number(std::string name, std::string group, Range range, std::string sentence,
                            Reference reference) {
    using Target = std::decay_t<decltype(reference(std::declval<ConversionOptions&>()))>;
    constexpr OptionType kType =
        std::is_integral_v<Target> ? OptionType::integer : OptionType::number;
    return {{std::move(name),
             std::move(group),
             kType,
             {},
             range.minimum,
             range.maximum,
             std::move(sentence)},
            [reference](JobOptions& options, const OptionValue& value) {
                reference(options.conversion) = static_cast<Target>(std::get<double>(value));
            },
            [reference](const JobOptions& options) -> Json {
                ConversionOptions copy = options.conversion;
                return reference(copy);
            }};
}

/// A number or a word that stands for "no number".
template <typename Reference>
[[nodiscard]] Option numberOr(const std::string& word, std::string name, std::string group,
                              Range range, std::string sentence, Reference reference) {
    using Target =
        typename std::decay_t<decltype(reference(std::declval<ConversionOptions&>()))>::value_type;
    constexpr OptionType kType =
        std::is_integral_v<Target> ? OptionType::integer : OptionType::number;
    return {{std::move(name),
             std::move(group),
             kType,
             {word},
             range.minimum,
             range.maximum,
             std::move(sentence)},
            [reference](JobOptions& options, const OptionValue& value) {
                if (std::holds_alternative<Word>(value))
                    reference(options.conversion).reset();
                else
                    reference(options.conversion) = static_cast<Target>(std::get<double>(value));
            },
            [reference, word](const JobOptions& options) -> Json {
                ConversionOptions copy = options.conversion;
                const auto& target = reference(copy);
                return target ? Json(*target) : Json(word);
            }};
}

}  // namespace rivage::proto
