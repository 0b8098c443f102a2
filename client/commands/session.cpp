#include "client/commands/session.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "client/inputs.h"
#include "client/printable.h"
#include "client/reference/command_tree.h"

namespace rivage::client {
namespace {

/// More than any server takes; keeps an endless stdin out of memory.
constexpr std::size_t kMostInput = std::size_t{2} << 30;

tl::unexpected<Failure> cannotRead(const std::string& why) {
    return fail(ExitCode::usage, "The input cannot be read", why);
}

tl::unexpected<Failure> tooLarge() {
    return fail(ExitCode::refused, "The input is too large", "it has more than 2 GiB");
}

Outcome<std::string> readAll(std::istream& stream) {
    std::string bytes;
    std::string chunk(std::size_t{1} << 16, '\0');
    while (stream.read(chunk.data(), static_cast<std::streamsize>(chunk.size())) ||
           stream.gcount() > 0) {
        bytes.append(chunk, 0, static_cast<std::size_t>(stream.gcount()));
        if (bytes.size() > kMostInput) return tooLarge();
    }
    if (stream.bad()) return cannotRead("stdin broke");
    return bytes;
}

Outcome<std::string> readAll(int file, const Interrupt& interrupt) {
    std::string bytes;
    std::string chunk(std::size_t{1} << 16, '\0');
    for (;;) {
        if (!interrupt.await(file, POLLIN)) return fail(ExitCode::cancelled, "Cancelled");
        const ssize_t count = read(file, chunk.data(), chunk.size());
        if (count == 0) return bytes;
        if (count < 0 && errno != EINTR && errno != EAGAIN) return cannotRead(std::strerror(errno));
        if (count > 0) bytes.append(chunk, 0, static_cast<std::size_t>(count));
        if (bytes.size() > kMostInput) return tooLarge();
    }
}

/// A named pipe opens at once, and has nothing to read before somebody writes to it.
Outcome<std::string> readFile(const std::string& path, const Interrupt& interrupt) {
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) return cannotRead(std::strerror(errno));
    struct stat status {};
    const bool folder = fstat(file, &status) == 0 && S_ISDIR(status.st_mode);
    auto bytes =
        folder ? Outcome<std::string>(cannotRead("it is a folder")) : readAll(file, interrupt);
    close(file);
    return bytes;
}

/// A word as a shell takes it.
std::string quoted(const std::string& word) {
    const bool plain = !word.empty() && word.find_first_not_of(
                                            "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                            "0123456789-_./:=@%+,") == std::string::npos;
    if (plain) return word;
    if (printable(word) == word) return shellQuoted(word);
    std::string text = "$'";  // every byte as a number: bash, zsh and ksh take that
    for (const char c : word) {
        char number[8];
        std::snprintf(number, sizeof number, "\\x%02x", static_cast<unsigned char>(c));
        text += number;
    }
    return text + "'";
}

std::string recovery(const Session& session, const Failure& failure, const std::string& output) {
    if (failure.job.empty() || session.own) return {};
    std::string command = "rivage jobs fetch " + failure.job;
    if (!output.empty()) command += " -o " + quoted(output);
    command += " --server " + quoted(toText(session.server.endpoint));
    if (!session.server.caFile.empty()) command += " --ca-file " + quoted(session.server.caFile);
    return "  the job stays at the server; to fetch its result later:\n    " + command + "\n";
}

}  // namespace

Transport Session::connect() const {
    Transport transport(server, interrupt, invocation.retry);
    transport.setDeadline(Clock::now() + invocation.timeout);
    return transport;
}

std::string complaintText(const Session& session, const std::string& about, const Failure& failure,
                          const std::string& output) {
    return painted(session.console, Tone::bad, "rivage: ") +
           (about.empty() ? "" : printable(about) + ": ") + describe(failure) + "\n" +
           recovery(session, failure, output);
}

ExitCode complain(const Invocation& invocation, Console& console, const std::string& about,
                  const Failure& failure) {
    if (invocation.json) console.out << jsonLine(failure.problem) << std::flush;
    console.err << painted(console, Tone::bad, "rivage: ")
                << (about.empty() ? "" : printable(about) + ": ") << describe(failure) << "\n"
                << std::flush;
    return failure.exit;
}

Failure inWordsOfFiles(const std::string& path, std::string_view start, Failure failure) {
    if (failure.exit != ExitCode::refused || textOf(failure.problem, "field") != "/grid")
        return failure;
    const bool vox = path.ends_with(".vox") && !start.starts_with("VOX ");
    const bool npy = path.ends_with(".npy") && !start.starts_with("\x93NUMPY");
    if (vox || npy) {
        failure.problem["title"] =
            vox ? "This is not a MagicaVoxel file" : "This is not a NumPy file";
        failure.problem["detail"] =
            vox ? "it does not begin with \"VOX \"" : "it does not begin with \"\\x93NUMPY\"";
    }
    // The file is named before; but what a limit is for has to be said.
    if (!failure.problem.contains("limit")) failure.problem.erase("field");
    return failure;
}

Outcome<std::string> readInput(const std::string& path, Console& console,
                               const Interrupt& interrupt) {
    if (path != kStandardStream) return readFile(path, interrupt);
    return console.inFile < 0 ? readAll(console.in) : readAll(console.inFile, interrupt);
}

}  // namespace rivage::client
