#include <algorithm>
#include <cctype>
#include <utility>

#include "client/reference/command_tree.h"
#include "client/reference/reference.h"

namespace rivage::client {
namespace {

/// Text as roff shows it: nothing in it is a request or an escape, hyphens can be copied.
std::string plain(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (out.empty() || out.back() == '\n') {
            if (c == ' ' || c == '\n') continue;
            if (c == '.' || c == '\'') out += "\\&";
        }
        switch (c) {
            case '\\': out += "\\e"; break;
            case '-': out += "\\-"; break;
            case '\'': out += "\\(aq"; break;
            case '"': out += "\\(dq"; break;
            case '`': out += "\\(ga"; break;
            case '^': out += "\\(ha"; break;
            case '~': out += "\\(ti"; break;
            default: out += c;
        }
    }
    return out;
}

std::string bold(const std::string& text) { return "\\fB" + plain(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + plain(text) + "\\fR"; }

std::string oneLine(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

std::string section(const std::string& title) { return ".SH " + title + "\n"; }

std::string entry(const std::string& term, const std::string& text) {
    return ".TP\n" + term + "\n" + (text.empty() ? "\\&" : text) + "\n";
}

std::string paragraphs(const std::string& text) {
    std::string out;
    std::string paragraph;
    const auto flush = [&] {
        if (paragraph.empty()) return;
        out += (out.empty() ? "" : ".PP\n") + plain(oneLine(std::exchange(paragraph, {}))) + "\n";
    };
    for (const char c : text) {
        if (c == '\n' && !paragraph.empty() && paragraph.back() == '\n')
            flush();
        else
            paragraph += c;
    }
    flush();
    return out;
}

/// "-o, --out PATH"
std::string optionTerm(const TreeOption& option) {
    std::string term;
    for (const std::string& name : option.names) term += (term.empty() ? "" : ", ") + bold(name);
    if (option.takesValue) term += " " + italic(option.value.name);
    return term;
}

std::string optionText(const TreeOption& option) {
    std::vector<std::string> facts;
    if (option.required) facts.emplace_back("required");
    const std::vector<std::string>& words = option.value.words;
    if (!words.empty() && option.value.name.find(words.front()) == std::string::npos)
        facts.push_back("one of " + joined(words, ", "));
    if (!option.value.range.empty()) facts.push_back("range: " + option.value.range);
    if (!option.defaultText.empty()) facts.push_back("default: " + option.defaultText);
    if (!option.environment.empty()) facts.push_back("environment: " + option.environment);
    std::string text = plain(oneLine(option.description));
    if (!facts.empty()) text += (text.empty() ? "(" : " (") + plain(joined(facts, "; ")) + ")";
    return text;
}

/// The options group by group, in the order in which the groups turn up.
std::string optionList(const std::vector<TreeOption>& options) {
    std::vector<std::string> groups;
    for (const TreeOption& option : options)
        if (std::find(groups.begin(), groups.end(), option.group) == groups.end())
            groups.push_back(option.group);
    std::string list;
    for (const std::string& group : groups) {
        if (groups.size() > 1) list += ".PP\n" + bold(group) + "\n";
        for (const TreeOption& option : options)
            if (option.group == group) list += entry(optionTerm(option), optionText(option));
    }
    return list;
}

std::string positionalName(const TreeOption& positional) {
    const std::string name = italic(positional.positional) + (positional.many ? " ..." : "");
    return positional.required ? name : "[" + name + "]";
}

/// "rivage jobs fetch [OPTIONS] ID"
std::string usage(const TreeCommand& command) {
    std::string text = bold(pathText(command));
    if (!command.options.empty() || !command.inherited.empty())
        text += " [" + italic("OPTIONS") + "]";
    for (const TreeOption& positional : command.positionals)
        text += " " + positionalName(positional);
    if (!command.commands.empty()) text += " " + italic("COMMAND") + " ...";
    return text;
}

std::string positionalList(const TreeCommand& command) {
    std::string list;
    for (const TreeOption& positional : command.positionals) {
        std::string name = italic(positional.positional);
        const std::string& kind = positional.value.name;
        if (kind != "TEXT" && kind != positional.positional) name += " (" + plain(kind) + ")";
        list += entry(name, optionText(positional));
    }
    return list;
}

/// The options of a command that are not told once for all commands, as --help is.
std::vector<TreeOption> ownOptions(const TreeCommand& command, const TreeCommand& root) {
    std::vector<TreeOption> own = command.options;
    std::erase_if(own, [&](const TreeOption& option) {
        return std::any_of(root.options.begin(), root.options.end(), [&](const TreeOption& told) {
            return told.names == option.names && told.description == option.description;
        });
    });
    return own;
}

std::string commandText(const TreeCommand& command, const TreeCommand& root) {
    std::string text = ".SS " + pathText(command) + "\n" + usage(command) + "\n";
    if (!command.description.empty()) text += ".PP\n" + plain(oneLine(command.description)) + "\n";
    if (!command.aliases.empty())
        text += ".PP\nAlso: " + bold(joined(command.aliases, ", ")) + "\n";
    return text + positionalList(command) + optionList(ownOptions(command, root));
}

std::string entryList(const char* title, const std::vector<ManEntry>& entries) {
    if (entries.empty()) return {};
    std::string list = section(title);
    for (const ManEntry& one : entries) list += entry(bold(one.term), plain(oneLine(one.text)));
    return list;
}

/// The variables that options name, then those of the text that no option names.
std::vector<ManEntry> environmentOf(const std::vector<const TreeCommand*>& commands,
                                    const std::vector<ManEntry>& more) {
    std::vector<ManEntry> list;
    const auto add = [&](const ManEntry& one) {
        const auto same = [&](const ManEntry& other) { return other.term == one.term; };
        if (std::none_of(list.begin(), list.end(), same)) list.push_back(one);
    };
    for (const TreeCommand* command : commands)
        for (const TreeOption& option : command->options)
            if (!option.environment.empty())
                add({option.environment, "The same as " + option.names.back() + "."});
    for (const ManEntry& one : more) add(one);
    return list;
}

std::string examplesText(const std::vector<ManEntry>& examples) {
    if (examples.empty()) return {};
    std::string text = section("EXAMPLES");
    for (std::size_t i = 0; i < examples.size(); ++i)
        text += (i == 0 ? "" : ".PP\n") + plain(oneLine(examples[i].text)) + "\n.PP\n.RS 4\n.nf\n" +
                bold(examples[i].term) + "\n.fi\n.RE\n";
    return text;
}

std::string seeAlsoText(const std::vector<std::string>& pages) {
    if (pages.empty()) return {};
    std::string text = section("SEE ALSO");
    for (std::size_t i = 0; i < pages.size(); ++i) {
        const std::size_t open = std::min(pages[i].find('('), pages[i].size());
        text += ".BR " + plain(pages[i].substr(0, open)) + " " + plain(pages[i].substr(open)) +
                (i + 1 < pages.size() ? " ,\n" : "\n");
    }
    return text;
}

/// The sentence without its end, as the line under NAME wants it.
std::string summary(std::string description) {
    description = oneLine(description);
    if (description.ends_with('.')) description.pop_back();
    return description;
}

std::string header(const std::string& name, const ManPageText& text) {
    std::string title = name;
    for (char& c : title) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return ".TH \"" + plain(title) + "\" 1 \"" + text.date + "\" \"" + plain(text.version) +
           "\" \"User Commands\"\n";
}

}  // namespace

std::string manPage(const CLI::App& app, const ManPageText& text) {
    const TreeCommand root = readTree(app);
    const std::vector<const TreeCommand*> commands = flatten(root);
    const std::string name = pathText(root);

    std::string page = header(name, text) + section("NAME") + plain(name) + " \\- " +
                       plain(summary(root.description)) + "\n" + section("SYNOPSIS") + usage(root);
    for (const TreeCommand* command : commands)
        if (command != &root && command->commands.empty()) page += "\n.br\n" + usage(*command);
    page += "\n";
    if (!text.description.empty()) page += section("DESCRIPTION") + paragraphs(text.description);
    page += section("OPTIONS") + positionalList(root) + optionList(root.options);
    if (commands.size() > 1) page += section("COMMANDS");
    for (const TreeCommand* command : commands)
        if (command != &root) page += commandText(*command, root);
    return page + entryList("ENVIRONMENT", environmentOf(commands, text.environment)) +
           entryList("FILES", text.files) + entryList("EXIT STATUS", text.exitStatus) +
           examplesText(text.examples) + seeAlsoText(text.seeAlso);
}

}  // namespace rivage::client
