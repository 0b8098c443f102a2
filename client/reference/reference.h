#pragma once

#include <CLI/App.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace rivage::client {

/// A term and what it means, for the lists of a man page.
struct ManEntry {
    std::string term;
    std::string text;
};

/// What a man page says that no tree of options knows. Empty parts are left out.
struct ManPageText {
    std::string version;                ///< "Rivage 0.1.0", the footer
    std::string description;            ///< paragraphs, an empty line between them
    std::vector<ManEntry> environment;  ///< beside the variables that the options name themselves
    std::vector<ManEntry> files;        ///< a path, what it holds
    std::vector<ManEntry> exitStatus;   ///< a code, what it means
    std::vector<ManEntry> examples;     ///< `term` is the command, `text` a sentence before it
    std::vector<std::string> seeAlso;   ///< "rivage-server(1)"
    std::string date;                   ///< "2026-01-31", of the release
};

enum class Shell : std::uint8_t { bash, zsh, fish };

/// The shell of that name, if there is one: `bash`, `zsh`, `fish`.
[[nodiscard]] std::optional<Shell> shellOf(std::string_view name);

/// The man page of a program, section 1, in roff with the man macros. Name, synopsis, commands and
/// options come from the tree alone; options of the empty group are hidden, as in --help.
[[nodiscard]] std::string manPage(const CLI::App& app, const ManPageText& text);

/// The completion script of a program for a shell, from the tree alone. It completes
/// - commands, at every depth, and the options of the command that has been typed; those of the
///   commands above it too where they fall through;
/// - the words of a value: those of CLI::IsMember, and the lower-case ones of a type name such as
///   `auto|none|NUMBER` (whatever has a capital letter stands for something else);
/// - file names where the type name has the word FILE, PATH or IN, folders for FOLDER or DIR; a
///   positional without a type name is taken by its own name.
[[nodiscard]] std::string completionScript(const CLI::App& app, Shell shell);

}  // namespace rivage::client
