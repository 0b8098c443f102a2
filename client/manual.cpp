#include "client/manual.h"

namespace rivage::client {
namespace {

constexpr const char* kDescription =
    "rivage sends voxel grids to a rivage-server, follows the jobs and writes the surfaces that "
    "come back. Without --server, and without RIVAGE_SERVER, it starts the rivage-server that "
    "stands beside it on a private Unix socket, for this run alone.\n"
    "\n"
    "Inputs are files, '-' for stdin, folders, in which it finds the grids at any depth, and "
    "patterns that the shell did not expand: '*', '?', '[a-z]', and '**' for any number of "
    "folders. Below -o the results stand as their inputs stand below the folder that was named. "
    "A result appears under its name only when it is whole and has the digest that the server "
    "names; a download that breaks off goes on where it broke.\n"
    "\n"
    "Results go to files or stdout, words to stderr. With --json there is one line for each input "
    "on stdout, as they end: its report or its problem, with a member \"run\" that has input, "
    "output, job, bytes, seconds and, if it failed, exit.\n"
    "\n"
    "Tried again, with growing random delays and what Retry-After asks for: 408, 429, 502, 503 "
    "and 504 until --timeout, a server that cannot be reached or breaks off a few times. Where a "
    "job stays at the server, the last words say how its result is fetched. Ctrl-C cancels it.\n"
    "\n"
    "Every option of regularize and every option that all commands have can also be set in the "
    "environment and in a file. The command line wins over the environment, the environment over "
    "the file.";

}  // namespace

ManPageText manualText() {
    ManPageText text;
    text.version = "Rivage " RIVAGE_VERSION;
    text.description = kDescription;
    text.environment = {
        {"RIVAGE_API_KEY", "The API key itself; --api-key-file wins over it."},
        {"NO_COLOR", "If set, there are no colours unless --color=always asks for them."},
        {"TERM", "\"dumb\" turns bars and colours off."},
        {"XDG_CONFIG_HOME", "Where the file of settings is looked for."}};
    text.files = {{"~/.config/rivage/config",
                   "Settings, one 'name = value' a line, such as 'preset = architectural'; '#' "
                   "begins a comment. Unknown names are refused."}};
    text.exitStatus = {
        {"0", "Done. Also --watch after Ctrl-C, if no conversion was under way."},
        {"2", "The command line or a setting is wrong, or an input cannot be read."},
        {"3", "The server refused the input or an option."},
        {"4", "No server answers, the connection broke for good, or a result arrived damaged."},
        {"5", "The server stayed full, or the time was over."},
        {"6",
         "The job or the server failed; or files differ more than compare allows, or lack a "
         "partner."},
        {"7", "Cancelled."},
        {"8", "The result could not be written."}};
    text.examples = {
        {"rivage regularize house.vox", "Writes house.glb, with no server running:"},
        {"rivage regularize models -o out --if-newer",
         "All grids below a folder, but those whose results are newer:"},
        {"rivage regularize 'models/**/*.vox' -o out --watch", "Again whenever one changes:"},
        {"rivage jobs list --state failed --server http://127.0.0.1:8080",
         "What failed at a server:"},
        {"rivage options preset", "Which presets there are:"},
        {"rivage compare before after --max-distance 0.1",
         "Whether a new version made other surfaces of a folder of grids:"},
        {"source <(rivage completions bash)", "Completion in this shell, which is bash:"},
        {"rivage completions bash > ~/.local/share/bash-completion/completions/rivage",
         "Completion in bash, for good:"},
        {"rivage completions zsh > ~/.zfunc/_rivage",
         "Completion in zsh, with fpath+=~/.zfunc before compinit in ~/.zshrc:"},
        {"rivage completions fish > ~/.config/fish/completions/rivage.fish", "Completion in fish:"},
        {"rivage man > ~/.local/share/man/man1/rivage.1", "This page for man(1):"}};
    text.seeAlso = {"rivage-load(1)"};
    return text;
}

}  // namespace rivage::client
