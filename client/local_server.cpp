#include "client/local_server.h"

#include <fcntl.h>
#include <httplib.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace rivage::client {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

constexpr milliseconds kStartTime{15'000};
constexpr milliseconds kStopTime{5'000};
constexpr milliseconds kStep{10};
constexpr std::size_t kMostWords = 2000;  ///< bytes of the server's output in an error

/// Becomes the server. Runs in the forked child, so only what is safe there. A fork of our own and
/// not posix_spawn, because only so the child can ask to die with its parent.
[[noreturn]] void becomeServer(char* const* arguments, char* const* environment, int words,
                               pid_t parent) {
    setpgid(0, 0);  // Ctrl-C on the terminal is for the client, which cancels the job first
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(127);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    const int nothing = open("/dev/null", O_RDONLY);
    dup2(nothing, 0);
    dup2(words, 1);
    dup2(words, 2);
    execve(arguments[0], arguments, environment);
    constexpr char kText[] = "cannot be executed";
    const auto written = write(2, kText, sizeof kText - 1);
    _exit(written < 0 ? 126 : 127);
}

/// The folder for temporary files, if the path of a socket fits into it.
fs::path socketParent() {
    constexpr std::size_t kLongest = 80;  // of the 107 bytes that a socket's path may have
    std::error_code error;
    const fs::path temporary = fs::temp_directory_path(error);
    return error || temporary.native().size() > kLongest ? fs::path("/tmp") : temporary;
}

/// The environment without the settings of servers: one that somebody set for another server would
/// make this one ask for a key, or share a folder.
std::vector<char*> cleanEnvironment() {
    std::vector<char*> kept;
    for (char** entry = environ; entry != nullptr && *entry != nullptr; ++entry)
        if (!std::string_view(*entry).starts_with("RIVAGE_")) kept.push_back(*entry);
    kept.push_back(nullptr);
    return kept;
}

bool answers(const std::string& socket) {
    if (access(socket.c_str(), F_OK) != 0) return false;
    httplib::Client client(socket, 80);
    client.set_address_family(AF_UNIX);
    client.set_connection_timeout(milliseconds(200));
    client.set_max_timeout(milliseconds(2000));
    return static_cast<bool>(client.Get("/version"));
}

}  // namespace

std::string serverBeside() {
    std::error_code error;
    const fs::path self = fs::read_symlink("/proc/self/exe", error);
    return (self.parent_path() / "rivage-server").string();
}

Outcome<LocalServer> LocalServer::start(const std::string& program, std::size_t workers,
                                        Interrupt& interrupt) {
    LocalServer server;
    std::string folder = (socketParent() / "rivage.XXXXXX").string();
    if (mkdtemp(folder.data()) == nullptr)
        return server.notStarted("no folder for its socket: " + std::string(std::strerror(errno)));
    server.folder_ = folder;
    const std::string log = folder + "/log";
    const int words = open(log.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    if (words < 0) return server.notStarted(std::strerror(errno));

    const std::size_t threads =
        std::max<std::size_t>(std::thread::hardware_concurrency() / workers, 1);
    std::vector<std::string> texts{program, "--listen=unix:" + server.endpoint().host,
                                   "--admin-listen=off", "--workers=" + std::to_string(workers),
                                   "--threads-per-job=" + std::to_string(threads)};
    std::vector<char*> arguments;
    arguments.reserve(texts.size() + 1);
    for (std::string& text : texts) arguments.push_back(text.data());
    arguments.push_back(nullptr);
    const std::vector<char*> environment = cleanEnvironment();
    const pid_t parent = getpid();
    server.child_ = fork();
    if (server.child_ == 0) becomeServer(arguments.data(), environment.data(), words, parent);
    close(words);
    if (server.child_ < 0) return server.notStarted(std::strerror(errno));

    for (milliseconds waited{0}; waited < kStartTime; waited += kStep) {
        if (answers(server.endpoint().host)) return server;
        if (server.ended()) return server.notStarted(program + " ended at once");
        if (!interrupt.sleep(kStep)) return fail(ExitCode::cancelled, "Cancelled");
    }
    return server.notStarted(program + " does not answer");
}

LocalServer::LocalServer(LocalServer&& other) noexcept
    : folder_(std::exchange(other.folder_, {})), child_(std::exchange(other.child_, -1)) {}

LocalServer::~LocalServer() {
    if (child_ > 0) kill(child_, SIGTERM);
    for (milliseconds waited{0}; child_ > 0 && !ended(); waited += kStep) {
        if (waited >= kStopTime) kill(child_, SIGKILL);
        usleep(static_cast<useconds_t>(1000 * kStep.count()));
    }
    std::error_code ignored;
    if (!folder_.empty()) fs::remove_all(folder_, ignored);
}

bool LocalServer::ended() {
    if (child_ > 0 && waitpid(child_, nullptr, WNOHANG) != 0) child_ = -1;
    return child_ < 0;
}

tl::unexpected<Failure> LocalServer::notStarted(const std::string& why) const {
    std::ifstream log(folder_ + "/log");
    std::string words{std::istreambuf_iterator<char>(log), {}};
    words.resize(std::min(words.size(), kMostWords));
    while (words.ends_with('\n')) words.pop_back();
    std::replace(words.begin(), words.end(), '\n', ' ');
    return fail(ExitCode::unreachable, "The server for this run did not start",
                why + (words.empty() ? "" : ": " + words) +
                    "; name another one with --server or RIVAGE_SERVER");
}

}  // namespace rivage::client
