#include "client/load/manual.h"

#include <CLI/CLI.hpp>

#include "client/load/command_line.h"
#include "client/reference/reference.h"

namespace rivage::client::load {
namespace {

std::vector<ManEntry> examples() {
    return {{"rivage-load run --server http://127.0.0.1:8080 --rate 20 --slo p99=500ms",
             "The sample island, 20 times a second for 10 s; exit code 1 if the limit is missed:"},
            {"rivage-load run --server http://127.0.0.1:8080 --concurrency 4 --mix mix.json --out "
             "out/load",
             "Four clients that ask as soon as they are answered, and a report in all its forms:"},
            {"rivage-load run --server http://127.0.0.1:8080 --get /version --rate 5000 --poisson",
             "A plain page, at random times:"},
            {"rivage-load search --server http://127.0.0.1:8080 --slo p99=1s",
             "The highest rate that keeps the limit:"},
            {"rivage-load selftest", "Is the generator itself good enough on this machine?"}};
}

std::vector<ManEntry> exitStatus() {
    return {
        {"0", "done, and everything was kept"},
        {"1", "a threshold of the mix or the limit of --slo was missed, or no answer was good"},
        {"2", "the command line, the mix or the trace is wrong"},
        {"3",
         "the generator was late or ran out of files: the figures say nothing about the server"},
        {"4", "no server answers"},
        {"7", "cancelled"},
        {"8", "a file could not be written"}};
}

/// A program that is described to its end, for what is made from its options.
struct Described {
    Described() { describeLoadCommandLine(app, options); }
    LoadOptions options;
    CLI::App app{"", "rivage-load"};
};

}  // namespace

std::string helpFooter() {
    std::string text = "Examples:\n";
    for (const ManEntry& example : examples()) text += "  " + example.term + "\n";
    text += "\nExit codes:\n";
    for (const ManEntry& code : exitStatus()) text += "  " + code.term + "  " + code.text + "\n";
    return text;
}

std::string loadManPage() {
    ManPageText text;
    text.version = "Rivage " RIVAGE_VERSION;
    text.description =
        "Sends a load to a rivage-server and tells how it was answered. An open loop sends at "
        "times that were planned before, whatever the answers do; a closed loop sends as soon as "
        "it is answered. Latency counts from the planned send, so that a server that stands still "
        "cannot hide it.\n\n"
        "Only servers on this machine are asked, unless --i-own-this is given.";
    text.environment = {{"RIVAGE_API_KEY", "the API key, if there is no --api-key-file"}};
    text.exitStatus = exitStatus();
    text.examples = examples();
    text.seeAlso = {"rivage(1)"};
    return manPage(Described().app, text);
}

std::string loadCompletions(const std::string& shell) {
    return completionScript(Described().app, shellOf(shell).value_or(Shell::bash));
}

}  // namespace rivage::client::load
