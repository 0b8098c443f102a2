#include "client/reference/command_tree.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>

namespace rivage::client {
namespace {

bool isUpper(char c) { return c >= 'A' && c <= 'Z'; }
bool isPlain(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("._+-/@%").find(c) != std::string_view::npos;
}

/// Whether a shell takes the text as one word that needs no quotes.
bool isWord(std::string_view text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), isPlain);
}

std::vector<std::string> split(std::string_view text, char at) {
    std::vector<std::string> parts(1);
    for (const char c : text) {
        if (c == at)
            parts.emplace_back();
        else
            parts.back() += c;
    }
    return parts;
}

/// Where the descriptions of the checks begin, which CLI11 puts behind the name of the type with a
/// colon between; a name such as HOST:PORT has a colon of its own.
std::size_t checksStart(std::string_view type) {
    for (std::size_t at = type.find(':'); at != std::string_view::npos;
         at = type.find(':', at + 1)) {
        const std::string_view rest = type.substr(at + 1);
        for (const char* check : {"{", "FILE", "DIR", "PATH(", "INT in [", "UINT in [",
                                  "FLOAT in [", "POSITIVE", "NONNEGATIVE", "NUMBER"})
            if (rest.starts_with(check)) return at;
    }
    return type.size();
}

/// The words of `{a,b}` or `{a->1,b->2}`.
std::vector<std::string> membersOf(std::string_view checks) {
    const std::size_t open = checks.find('{');
    const std::size_t close = checks.find('}', open);
    if (open == std::string_view::npos || close == std::string_view::npos) return {};
    std::vector<std::string> words;
    for (const std::string& member : split(checks.substr(open + 1, close - open - 1), ',')) {
        const std::string word = member.substr(0, member.find("->"));
        if (isWord(word)) words.push_back(word);
    }
    return words;
}

void readPlaceholder(const std::string& word, ValueKind& kind) {
    if (word == "FILE" || word == "IN" || word.starts_with("PATH")) kind.files = true;
    if (word == "DIR" || word == "FOLDER" || word == "FOLDER/") kind.folders = true;
}

ValueKind kindOf(const std::string& type, const std::string& positional) {
    ValueKind kind;
    const std::size_t end = checksStart(type);
    const std::string name = type.substr(0, end);
    const std::string checks = end < type.size() ? type.substr(end + 1) : std::string();
    kind.words = membersOf(checks);
    for (const std::string& word : split(name, '|')) {
        if (!isWord(word) || std::any_of(word.begin(), word.end(), isUpper))
            readPlaceholder(word, kind);
        else if (std::find(kind.words.begin(), kind.words.end(), word) == kind.words.end())
            kind.words.push_back(word);
    }
    for (const std::string& check : split(checks, ':')) readPlaceholder(check, kind);
    if (name == "TEXT" && kind.words.empty()) readPlaceholder(positional, kind);
    kind.folders = kind.folders && !kind.files;
    kind.name = name == "TEXT" && !kind.words.empty() ? joined(kind.words, "|") : name;
    const std::size_t from = checks.find(" in [");
    if (from != std::string_view::npos) {
        const std::size_t start = from + std::string_view(" in [").size();
        kind.range = checks.substr(start, checks.find(']', start) - start);
    }
    return kind;
}

TreeOption readOption(const CLI::Option& option) {
    TreeOption out;
    for (const std::string& name : option.get_snames()) out.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) out.names.push_back("--" + name);
    if (option.get_positional()) out.positional = option.get_name(true);
    out.description = option.get_description();
    out.group = option.get_group();
    out.defaultText = option.get_default_str();
    out.environment = option.get_envname();
    out.takesValue = option.get_items_expected_max() > 0;
    out.many = option.get_items_expected_max() > 1;
    out.required = option.get_required();
    if (out.takesValue) out.value = kindOf(option.get_type_name(), out.positional);
    return out;
}

/// Puts the options of an app into the command; option groups are nameless apps, with a --help
/// that nobody can reach.
void readOptions(const CLI::App& app, TreeCommand& command) {
    for (const CLI::Option* option : app.get_options()) {
        const bool unreachable = app.get_name().empty() && option == app.get_help_ptr();
        if (option->get_group().empty() || unreachable) continue;
        TreeOption read = readOption(*option);
        auto& list = read.names.empty() ? command.positionals : command.options;
        list.push_back(std::move(read));
    }
    for (const CLI::App* group : app.get_subcommands({}))
        if (group->get_name().empty() && !group->get_disabled()) readOptions(*group, command);
}

TreeCommand readCommand(const CLI::App& app, const TreeCommand* above) {
    TreeCommand command;
    if (above != nullptr) {
        command.path = above->path;
        if (app.get_fallthrough()) command.inherited = allOptions(*above);
    }
    command.path.push_back(app.get_name());
    command.aliases = app.get_aliases();
    command.description = app.get_description();
    readOptions(app, command);
    std::erase_if(command.inherited, [&](const TreeOption& outer) {  // --help has its own
        return std::any_of(command.options.begin(), command.options.end(),
                           [&](const TreeOption& own) { return own.names == outer.names; });
    });
    for (const CLI::App* below : app.get_subcommands({}))
        if (!below->get_name().empty() && !below->get_group().empty() && !below->get_disabled())
            command.commands.push_back(readCommand(*below, &command));
    return command;
}

void addFlattened(const TreeCommand& command, std::vector<const TreeCommand*>& list) {
    list.push_back(&command);
    for (const TreeCommand& below : command.commands) addFlattened(below, list);
}

}  // namespace

TreeCommand readTree(const CLI::App& app) { return readCommand(app, nullptr); }

std::vector<TreeOption> allOptions(const TreeCommand& command) {
    std::vector<TreeOption> options = command.options;
    options.insert(options.end(), command.inherited.begin(), command.inherited.end());
    return options;
}

std::vector<const TreeCommand*> flatten(const TreeCommand& command) {
    std::vector<const TreeCommand*> list;
    addFlattened(command, list);
    return list;
}

std::string pathText(const TreeCommand& command, const char* between) {
    return joined(command.path, between);
}

std::string identifier(std::string text) {
    for (char& c : text)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
    return text;
}

std::string shellQuoted(const std::string& text) {
    std::string quoted = "'";
    for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

}  // namespace rivage::client
