#include <CLI/App.hpp>

#include "client/command_tree.h"
#include "client/commands/local.h"
#include "client/commands/session.h"
#include "client/compare/compare.h"
#include "client/manual.h"
#include "client/printable.h"
#include "client/reference/reference.h"

namespace rivage::client {
namespace {

/// Calls `write` with the description of the whole command line.
template <typename Write>
ExitCode withTree(Console& console, Write write) {
    CLI::App app(kProgramSentence, "rivage");
    Parsed unused;
    describeCommandLine(app, unused);
    console.out << write(app);
    return ExitCode::ok;
}

}  // namespace

ExitCode runCompare(const Invocation& invocation, Console& console, const Interrupt& interrupt) {
    CompareSettings settings = invocation.compare;
    settings.nameA = invocation.inputs[0];
    settings.nameB = invocation.inputs[1];
    const auto a = readInput(settings.nameA, console, interrupt);
    if (!a) return complain(invocation, console, settings.nameA, a.error());
    const auto b = readInput(settings.nameB, console, interrupt);
    if (!b) return complain(invocation, console, settings.nameB, b.error());
    const auto comparison = compareAssets(*a, *b, settings);
    if (!comparison) return complain(invocation, console, {}, comparison.error());
    console.out << (invocation.json ? jsonLine(*comparison) : comparisonTable(*comparison))
                << std::flush;
    return console.out ? exitOf(*comparison) : ExitCode::ok;  // runCommand says what is wrong
}

ExitCode runCompletions(const Invocation& invocation, Console& console) {
    const auto shell = shellOf(invocation.inputs.front());
    return withTree(console, [&](const CLI::App& app) { return completionScript(app, *shell); });
}

ExitCode runMan(Console& console) {
    return withTree(console, [](const CLI::App& app) { return manPage(app, manualText()); });
}

}  // namespace rivage::client
