#include "client/reference/completions.h"

namespace rivage::client {
namespace {

/// Text for a specification of `_arguments`, where brackets and colons mean something.
std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '\n') {
            out += ' ';
            continue;
        }
        if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
        out += c;
    }
    return out;
}

std::string functionOf(const TreeCommand& command) {
    return "_" + identifier(pathText(command, "__"));
}

/// What completes a value: words, paths, both, or nothing.
std::string actionOf(const std::vector<std::string>& words, bool files, bool folders) {
    const std::string paths = files ? "_files" : folders ? "_path_files -/" : "";
    std::string list = "(" + joined(words, " ") + ")";
    if (words.empty()) return paths.empty() ? " " : paths;
    if (paths.empty()) return list;
    return "{_alternative \"words\\:word\\:" + list + "\" \"paths\\:path\\:" + paths + "\"}";
}

/// One specification a name; typing one name takes the others from the list.
std::string optionSpecs(const TreeOption& option) {
    std::string specs;
    for (const std::string& name : option.names) {
        std::string spec = option.many ? "*" : "(" + joined(option.names, " ") + ")";
        spec += name;
        const ValueKind& kind = option.value;
        if (option.takesValue) spec += name.starts_with("--") ? "=" : "+";
        spec += "[" + escaped(option.description) + "]";
        if (option.takesValue)
            spec += (option.many ? ":*-*:" : ":") + escaped(kind.name) + ":" +
                    actionOf(kind.words, kind.files, kind.folders);
        specs += "        " + shellQuoted(spec) + " \\\n";
    }
    return specs;
}

std::string positionalSpecs(const TreeCommand& command) {
    std::string specs;
    for (const TreeOption& positional : command.positionals) {
        const ValueKind& kind = positional.value;
        specs += "        " +
                 shellQuoted((positional.many ? "*:" : ":") + escaped(positional.positional) + ":" +
                             actionOf(kind.words, kind.files, kind.folders)) +
                 " \\\n";
    }
    return specs;
}

/// The list of commands, and the call of the function of the one that was typed.
std::string subcommandLines(const TreeCommand& command) {
    std::string list;
    std::string calls;
    for (const TreeCommand& below : command.commands) {
        std::string names = below.path.back();
        list += "                " + shellQuoted(names + ":" + escaped(below.description)) + "\n";
        for (const std::string& alias : below.aliases) names += " | " + alias;
        calls += "                " + names + ") " + functionOf(below) + " && ret=0 ;;\n";
    }
    return "    case $state in\n"
           "        command)\n"
           "            commands=(\n" +
           list +
           "            )\n"
           "            _describe -t commands command commands && ret=0 ;;\n"
           "        argument)\n"
           "            case $line[1] in\n" +
           calls +
           "            esac ;;\n"
           "    esac\n";
}

std::string functionText(const TreeCommand& command) {
    const bool nested = !command.commands.empty();
    std::string specs;
    for (const TreeOption& option : allOptions(command)) specs += optionSpecs(option);
    specs += nested ? "        '1: :->command' '*:: :->argument' \\\n" : positionalSpecs(command);
    return functionOf(command) +
           "() {\n"
           "    local curcontext=$curcontext state state_descr line ret=1\n"
           "    local -a commands\n"
           "    local -A opt_args\n"
           "    _arguments -C \\\n" +
           specs + "        && ret=0\n" + (nested ? subcommandLines(command) : "") +
           "    return ret\n"
           "}\n";
}

}  // namespace

std::string zshCompletion(const TreeCommand& root) {
    const std::string name = pathText(root);
    const std::string function = functionOf(root);
    std::string text =
        "#compdef " + name + "\n# zsh completion of " + name + ", made by the program itself\n";
    for (const TreeCommand* command : flatten(root)) text += functionText(*command);
    // The file is the body of the function when zsh loads it by itself, or it is sourced.
    return text + "if [[ $funcstack[1] == _" + name + " ]]; then\n    " + function +
           " \"$@\"\nelse\n    compdef " + function + " " + name + "\nfi\n";
}

}  // namespace rivage::client
