#include "client/reference/completions.h"

#include <utility>

#include "client/reference/reference.h"

namespace rivage::client {

Arguments argumentsOf(const TreeCommand& command) {
    Arguments next;
    for (const TreeCommand& below : command.commands) next.words.push_back(below.path.back());
    for (const TreeOption& positional : command.positionals) {
        const ValueKind& kind = positional.value;
        next.words.insert(next.words.end(), kind.words.begin(), kind.words.end());
        next.files = next.files || kind.files;
        next.folders = next.folders || kind.folders;
    }
    return next;
}

std::vector<Step> stepsOf(const std::vector<const TreeCommand*>& commands) {
    std::vector<Step> steps;
    for (const TreeCommand* command : commands) {
        for (const TreeCommand& below : command->commands) {
            std::vector<std::string> names = below.aliases;
            names.insert(names.begin(), below.path.back());
            steps.push_back({command, std::move(names), &below});
        }
        for (const TreeOption& option : allOptions(*command))
            if (option.takesValue) steps.push_back({command, option.names, nullptr, option.many});
    }
    return steps;
}

std::optional<Shell> shellOf(std::string_view name) {
    if (name == "bash") return Shell::bash;
    if (name == "zsh") return Shell::zsh;
    if (name == "fish") return Shell::fish;
    return std::nullopt;
}

std::string completionScript(const CLI::App& app, Shell shell) {
    const TreeCommand root = readTree(app);
    switch (shell) {
        case Shell::bash: return bashCompletion(root);
        case Shell::zsh: return zshCompletion(root);
        case Shell::fish: return fishCompletion(root);
    }
    return {};
}

}  // namespace rivage::client
