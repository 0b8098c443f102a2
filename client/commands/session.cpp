#include "client/commands/session.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "client/inputs.h"
#include "client/printable.h"
#include "client/reference/command_tree.h"

namespace rivage::client {
namespace {

/// More than any server takes; keeps an endless stdin out of memory.
constexpr std::size_t kMostInput = std::size_t{2} << 30;

Outcome<std::string> readAll(std::istream& stream, const std::string& name) {
    std::string bytes;
    std::string chunk(std::size_t{1} << 16, '\0');
    while (stream.read(chunk.data(), static_cast<std::streamsize>(chunk.size())) ||
           stream.gcount() > 0) {
        bytes.append(chunk, 0, static_cast<std::size_t>(stream.gcount()));
        if (bytes.size() > kMostInput)
            return fail(ExitCode::refused, "The grid is too large", name + " has more than 2 GiB");
    }
    if (stream.bad()) return fail(ExitCode::usage, "The input cannot be read", name);
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

Outcome<std::string> readInput(const std::string& path, Console& console) {
    if (path == kStandardStream) return readAll(console.in, "stdin");
    std::error_code error;
    if (std::filesystem::is_directory(path, error))
        return fail(ExitCode::usage, "The input cannot be read", path + " is a folder");
    std::ifstream file(path, std::ios::binary);
    if (!file) return fail(ExitCode::usage, "The input cannot be read", path);
    return readAll(file, path);
}

}  // namespace rivage::client
