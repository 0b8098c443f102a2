#include "client/reference/completions.h"

namespace rivage::client {
namespace {

/// The pattern of a `case` for some words after a command.
std::string patternOf(const TreeCommand& command, const std::vector<std::string>& words) {
    std::vector<std::string> patterns;
    patterns.reserve(words.size());
    for (const std::string& word : words)
        patterns.push_back(shellQuoted(pathText(command) + " " + word));
    return joined(patterns, " | ");
}

/// The lines by which a word that has been typed changes what may follow.
std::string stepCases(const std::vector<const TreeCommand*>& commands) {
    std::string cases;
    for (const Step& step : stepsOf(commands))
        cases +=
            "            " + patternOf(*step.after, step.words) + ") " +
            (step.command != nullptr ? "command=" + shellQuoted(pathText(*step.command))
                                     : std::string("option=$word") + (step.many ? " many=1" : "")) +
            " ;;\n";
    return cases;
}

std::string assignments(const std::vector<std::string>& words, bool files, bool folders) {
    std::string text;
    if (!words.empty()) text += " words=" + shellQuoted(joined(words, " "));
    if (files) text += " paths=-f";
    if (folders && !files) text += " paths=-d";
    return text;
}

std::string valueCases(const std::vector<const TreeCommand*>& commands) {
    std::string cases;
    for (const TreeCommand* command : commands)
        for (const TreeOption& option : allOptions(*command)) {
            const ValueKind& kind = option.value;
            const std::string set = assignments(kind.words, kind.files, kind.folders);
            if (option.takesValue && !set.empty())
                cases += "            " + patternOf(*command, option.names) + ")" + set + " ;;\n";
        }
    return cases;
}

std::string commandCases(const std::vector<const TreeCommand*>& commands) {
    std::string cases;
    for (const TreeCommand* command : commands) {
        const Arguments next = argumentsOf(*command);
        std::vector<std::string> options;
        for (const TreeOption& option : allOptions(*command))
            options.insert(options.end(), option.names.begin(), option.names.end());
        cases += "            " + shellQuoted(pathText(*command)) +
                 ") options=" + shellQuoted(joined(options, " ")) +
                 assignments(next.words, next.files, next.folders) + " ;;\n";
    }
    return cases;
}

}  // namespace

std::string bashCompletion(const TreeCommand& root) {
    const std::vector<const TreeCommand*> commands = flatten(root);
    const std::string name = pathText(root);
    const std::string function = "_" + identifier(name);
    return "# bash completion of " + name + ", made by the program itself\n" + function +
           "() {\n"
           "    local cur=${COMP_WORDS[COMP_CWORD]} command=" +
           shellQuoted(name) +
           " option='' many=''\n"
           "    local words='' options='' paths='' word i\n"
           "    COMPREPLY=()\n"
           "    for ((i = 1; i < COMP_CWORD; ++i)); do\n"
           "        word=${COMP_WORDS[i]}\n"
           "        [[ $word == '=' ]] && continue  # --option=value arrives as three words\n"
           "        if [[ -n $option && $word != -?* ]]; then\n"
           "            [[ -n $many ]] || option=''\n"
           "            continue\n"
           "        fi\n"
           "        option='' many=''\n"
           "        case \"$command $word\" in\n" +
           stepCases(commands) +
           "        esac\n"
           "    done\n"
           "    [[ $cur == '=' ]] && cur=''\n"
           "    if [[ -n $option && $cur != -?* ]]; then\n"
           "        case \"$command $option\" in\n" +
           valueCases(commands) +
           "        esac\n"
           "    else\n"
           "        case $command in\n" +
           commandCases(commands) +
           "        esac\n"
           "        [[ $cur == -* || -z $words$paths ]] && words=$options paths=''\n"
           "    fi\n"
           "    [[ -n $words ]] && mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$cur\")\n"
           "    if [[ -n $paths ]]; then\n"
           "        compopt -o filenames 2>/dev/null\n"
           "        mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen $paths -- \"$cur\")\n"
           "    fi\n"
           "}\n"
           "complete -F " +
           function + " " + shellQuoted(name) + "\n";
}

}  // namespace rivage::client
