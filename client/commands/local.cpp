#include <CLI/App.hpp>

#include "client/command_tree.h"
#include "client/commands/local.h"
#include "client/manual.h"
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

ExitCode runCompletions(const Invocation& invocation, Console& console) {
    const auto shell = shellOf(invocation.inputs.front());
    return withTree(console, [&](const CLI::App& app) { return completionScript(app, *shell); });
}

ExitCode runMan(Console& console) {
    return withTree(console, [](const CLI::App& app) { return manPage(app, manualText()); });
}

}  // namespace rivage::client
