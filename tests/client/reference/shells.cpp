#include "shells.h"

#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>

namespace rivage::client {
namespace {

void write(const std::string& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

// Splits the line as bash does: '=' and ':' are words of their own.
const char* const kBash = R"(
source "$1/script"
line=$2
words=()
for word in $line; do
    while [[ $word == *[=:]* ]]; do
        head=${word%%[=:]*}
        [[ -n $head ]] && words+=("$head")
        words+=("${word:${#head}:1}")
        word=${word:$((${#head} + 1))}
    done
    [[ -n $word ]] && words+=("$word")
done
[[ $line == *' ' ]] && words+=('')
COMP_WORDS=("${words[@]}")
COMP_CWORD=$((${#words[@]} - 1))
COMP_LINE=$line
COMP_POINT=${#line}
read -r _ _ function _ < <(complete -p "${words[0]}")
"$function"
printf '%s\n' "${COMPREPLY[@]}"
)";

const char* const kFish = R"(
source $argv[1]/script
complete -C $argv[2] | string replace -r '\t.*' ''
exit 0
)";

// A shell on a pseudo terminal, for zsh completes nowhere else; what it would add goes to a file.
const char* const kZsh = R"(
zmodload zsh/zpty
zpty shell zsh -f -i
zpty -w shell "
PROMPT= ; TERM=dumb ; autoload -U compinit ; compinit -u -D ; cd ${(q)3}
compadd() {
    local -a hits
    builtin compadd -A hits \"\$@\"
    print -rl -- \$hits >> ${(q)1}/hits
    (( \$#hits ))
}
source ${(q)1}/script
finish() { touch ${(q)1}/ready }
zle -N finish ; bindkey '^X' finish ; bindkey '^I' complete-word
touch ${(q)1}/prepared"
repeat 200; do [[ -e $1/prepared ]] && break; zpty -rt shell out; sleep 0.05; done
sleep 0.2
zpty -wn shell "$2"$'\t\x18'
repeat 200; do [[ -e $1/ready ]] && break; zpty -rt shell out; sleep 0.05; done
zpty -d shell
[[ -e $1/ready ]] || exit 1
cat $1/hits 2>/dev/null
exit 0
)";

std::string quoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

}  // namespace

bool isInstalled(const std::string& program) {
    int status = 0;
    (void)outputOf("command -v " + program, status);
    return status == 0;
}

std::string outputOf(const std::string& command, int& status) {
    std::string text;
    FILE* pipe = popen(("{ " + command + "; } 2>&1").c_str(), "r");
    if (pipe == nullptr) {
        status = -1;
        return text;
    }
    char block[4096];
    for (std::size_t got = 0; (got = fread(block, 1, sizeof block, pipe)) > 0;)
        text.append(block, got);
    const int ended = pclose(pipe);
    status = WIFEXITED(ended) ? WEXITSTATUS(ended) : -1;
    return text;
}

std::vector<std::string> offers(Shell shell, const std::string& script, const std::string& line,
                                const std::string& folder) {
    int status = 0;
    std::string work = outputOf("mktemp -d", status);
    work.erase(work.find_last_not_of('\n') + 1);
    write(work + "/script", script);
    write(work + "/driver", shell == Shell::bash ? kBash : shell == Shell::fish ? kFish : kZsh);
    const std::string program = shell == Shell::bash   ? "bash --norc"
                                : shell == Shell::fish ? "fish -N"
                                                       : "zsh -f";
    const std::string arguments = " " + work + " " + quoted(line) + " " + quoted(folder);
    std::istringstream lines(outputOf("cd " + quoted(folder) + " && HOME=" + work + " " + program +
                                          " " + work + "/driver" + arguments,
                                      status));
    std::vector<std::string> found;
    if (status != 0) found.push_back("the shell failed with " + std::to_string(status));
    for (std::string one; std::getline(lines, one);)
        if (!one.empty()) found.push_back(one);
    (void)outputOf("rm -rf " + work, status);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

}  // namespace rivage::client
