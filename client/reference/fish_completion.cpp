#include "client/reference/completions.h"

namespace rivage::client {
namespace {

std::string fishQuoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) {
        if (c == '\'' || c == '\\') out += '\\';
        out += c == '\n' ? ' ' : c;
    }
    return out + "'";
}

std::string patternOf(const TreeCommand& command, const std::vector<std::string>& words) {
    std::string patterns;
    for (const std::string& word : words)
        patterns += " " + fishQuoted(pathText(command) + " " + word);
    return patterns;
}

/// The lines by which a word that has been typed changes what may follow.
std::string stepCases(const std::vector<const TreeCommand*>& commands) {
    std::string cases;
    for (const Step& step : stepsOf(commands)) {
        cases += "            case" + patternOf(*step.after, step.words) + "\n                set ";
        cases += step.command != nullptr ? "command " + fishQuoted(pathText(*step.command))
                                         : "option " + step.words.back();
        cases += step.many ? "\n                set many 1\n" : "\n";
    }
    return cases;
}

/// How a value is completed: a flag of `complete` each.
std::string valueFlags(const ValueKind& kind) {
    std::string flags = kind.files ? " -r -F" : " -x";
    std::string words = joined(kind.words, " ");
    if (kind.folders) words += " (__fish_complete_directories)";
    if (!words.empty()) flags += " -a " + fishQuoted(words);
    return flags;
}

std::string optionLine(const std::string& start, const TreeOption& option) {
    std::string line = start;
    for (const std::string& name : option.names)
        line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    if (option.takesValue) line += valueFlags(option.value);
    return line + " -d " + fishQuoted(option.description) + "\n";
}

/// A line of `complete` up to the condition that this has been typed.
std::string lineStart(const std::string& name, const std::string& typed) {
    return "complete -c " + name + " -n " +
           fishQuoted("__" + identifier(name) + "_at " + fishQuoted(typed));
}

std::string argumentLines(const std::string& start, const ValueKind& kind) {
    std::string lines;
    if (kind.files) lines += start + " -F\n";
    if (kind.folders) lines += start + " -a '(__fish_complete_directories)'\n";
    if (!kind.words.empty()) lines += start + " -a " + fishQuoted(joined(kind.words, " ")) + "\n";
    return lines;
}

std::string commandLines(const std::string& name, const TreeCommand& command) {
    const std::string typed = pathText(command);
    const std::string start = lineStart(name, typed);
    std::string lines;
    for (const TreeCommand& below : command.commands)
        lines += start + " -a " + below.path.back() + " -d " + fishQuoted(below.description) + "\n";
    for (const TreeOption& positional : command.positionals)
        lines += argumentLines(start, positional.value);
    for (const TreeOption& option : allOptions(command)) {
        lines += optionLine(start, option);
        if (option.many)  // fish itself sees the first value only
            lines +=
                argumentLines(lineStart(name, typed + " " + option.names.back()), option.value);
    }
    return lines;
}

}  // namespace

std::string fishCompletion(const TreeCommand& root) {
    const std::vector<const TreeCommand*> commands = flatten(root);
    const std::string name = pathText(root);
    const std::string function = "__" + identifier(name) + "_at";
    std::string text =
        "# fish completion of " + name + ", made by the program itself\nfunction " + function +
        " --description 'Whether this command has been typed'\n"
        "    set -l command " +
        fishQuoted(name) +
        "\n"
        "    set -l option ''\n"
        "    set -l many ''\n"
        "    set -l typed (commandline -opc)\n"
        "    for word in $typed[2..-1]\n"
        "        if test -n \"$option\"; and not string match -q -- '-?*' $word\n"
        "            test -n \"$many\"; or set option ''\n"
        "            continue\n"
        "        end\n"
        "        set option ''\n"
        "        set many ''\n"
        "        switch \"$command $word\"\n" +
        stepCases(commands) +
        "        end\n"
        "    end\n"
        "    if test -n \"$many\"; and not string match -q -- '-*' (commandline -ct)\n"
        "        set command \"$command $option\"\n"
        "    end\n"
        "    test $command = $argv[1]\n"
        "end\n"
        "complete -c " +
        name + " -f\n";
    for (const TreeCommand* command : commands) text += commandLines(name, *command);
    return text;
}

}  // namespace rivage::client
