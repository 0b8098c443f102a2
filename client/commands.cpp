#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <system_error>

#include "client/command_line.h"
#include "client/conversion.h"
#include "client/local_server.h"
#include "client/output_file.h"
#include "client/plan.h"
#include "client/progress.h"
#include "client/report_table.h"

namespace rivage::client {
namespace {

using proto::Json;

/// More than any server takes; keeps an endless stdin out of memory.
constexpr std::size_t kMostInput = std::size_t{2} << 30;

/// What every command works with.
struct Session {
    const Invocation& invocation;
    Console& console;
    Transport transport;
};

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

Outcome<std::string> readInput(const std::string& path, Console& console) {
    if (path == kStandardStream) return readAll(console.in, "stdin");
    std::error_code error;
    if (std::filesystem::is_directory(path, error))
        return fail(ExitCode::usage, "The input cannot be read", path + " is a folder");
    std::ifstream file(path, std::ios::binary);
    if (!file) return fail(ExitCode::usage, "The input cannot be read", path);
    return readAll(file, path);
}

/// The place of one result: a file that appears when it is whole, or stdout.
class Target {
public:
    static Outcome<Target> open(const std::string& path, Console& console) {
        Target target(console);
        if (path == kStandardStream) {
            if (console.outIsTerminal)
                return fail(ExitCode::usage, "A terminal is no place for a binary file",
                            "use -o FILE, or send stdout to a file");
            return target;
        }
        auto file = OutputFile::open(path);
        if (!file) return tl::unexpected(file.error());
        target.file_.emplace(*std::move(file));
        return target;
    }

    [[nodiscard]] BodySink sink() {
        return {[this] { return file_ ? file_->restart() : (buffer_.clear(), true); },
                [this](std::string_view bytes) {
                    if (file_) return file_->write(bytes);
                    buffer_ += bytes;
                    return true;
                }};
    }
    [[nodiscard]] std::uint64_t size() const { return file_ ? file_->size() : buffer_.size(); }

    Outcome<void> commit() {
        if (file_) return file_->commit();
        console_->out.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size())).flush();
        if (!console_->out) return fail(ExitCode::notWritten, "stdout cannot be written");
        return {};
    }

private:
    explicit Target(Console& console) : console_(&console) {}
    Console* console_;
    std::optional<OutputFile> file_;
    std::string buffer_;
};

ExitCode complain(Console& console, const std::string& about, const Failure& failure) {
    console.err << "rivage: " << (about.empty() ? "" : about + ": ") << describe(failure) << "\n";
    return failure.exit;
}

Outcome<Json> convertFile(Session& session, const PlannedFile& file, ProgressLine& line) {
    auto bytes = readInput(file.input, session.console);
    if (!bytes) return tl::unexpected(bytes.error());
    auto target = Target::open(file.output, session.console);
    if (!target) return tl::unexpected(target.error());
    session.transport.setDeadline(Clock::now() + session.invocation.timeout);
    const Upload upload{*std::move(bytes), session.invocation.options};
    const ConversionWatch watch{[&](const JobProgress& progress) { line.update(progress); },
                                line.lively()};
    const BodySink sink = target->sink();
    auto report = convertGrid(session.transport, upload, sink, watch);
    if (!report) return report;
    const std::uint64_t size = target->size();
    if (auto committed = target->commit(); !committed) return tl::unexpected(committed.error());
    line.finish("-> " + file.output + ", " + bytesText(static_cast<double>(size)));
    return report;
}

ExitCode regularizeOne(Session& session, const PlannedFile& file) {
    const Invocation& invocation = session.invocation;
    ProgressLine line(session.console, file.input, invocation.quiet);
    const auto report = convertFile(session, file, line);
    if (invocation.json)
        session.console.out << proto::writeJson(report ? *report : report.error().problem) << "\n"
                            << std::flush;
    if (!report) {
        line.clear();
        return complain(session.console, file.input, report.error());
    }
    if (!invocation.quiet && !invocation.json) session.console.err << reportTable(*report);
    return ExitCode::ok;
}

std::string outputExtension(const std::vector<proto::OptionText>& options) {
    const auto parsed = proto::parseOptions(options);
    return parsed ? textOf(proto::toJson(*parsed), "output") : "glb";
}

/// All inputs, in their order. A failure does not keep the others from being converted, but a stop
/// does, and so does a server that is not there.
ExitCode runRegularize(Session& session, const std::vector<PlannedFile>& files) {
    ExitCode first = ExitCode::ok;
    for (const PlannedFile& file : files) {
        const ExitCode code = regularizeOne(session, file);
        if (first == ExitCode::ok) first = code;
        if (session.transport.interrupt().requested() || code == ExitCode::unreachable) break;
    }
    return first;
}

Outcome<std::vector<PlannedFile>> planRegularize(const Invocation& invocation) {
    auto files = planFiles(invocation.inputs, invocation.out, outputExtension(invocation.options));
    if (!files) return files;
    const bool toStdout = std::any_of(files->begin(), files->end(), [](const PlannedFile& file) {
        return file.output == kStandardStream;
    });
    if (toStdout && invocation.json)
        return fail(ExitCode::usage, "stdout cannot take both",
                    "--json prints there, so the result needs -o FILE");
    if (invocation.out.ends_with('/')) {
        std::error_code error;
        std::filesystem::create_directories(invocation.out, error);
        if (error)
            return fail(ExitCode::notWritten, "The folder cannot be made",
                        invocation.out + ": " + error.message());
    }
    return files;
}

/// A request whose answer is a JSON document, printed as JSON or as `table` makes it.
ExitCode show(Session& session, const httplib::Request& request,
              std::string (*table)(const Json&)) {
    const auto response = session.transport.send(request);
    if (!response) return complain(session.console, {}, response.error());
    const Json json = Json::parse(response->body, nullptr, false);
    if (!json.is_object())
        return complain(session.console, {}, failureOf(500, "The answer is no JSON object"));
    session.console.out << (session.invocation.json ? proto::writeJson(json) + "\n" : table(json))
                        << std::flush;
    return session.console.out ? ExitCode::ok : ExitCode::notWritten;
}

ExitCode runInspect(Session& session) {
    auto bytes = readInput(session.invocation.inputs.front(), session.console);
    if (!bytes) return complain(session.console, {}, bytes.error());
    const Upload upload{*std::move(bytes), session.invocation.options};
    return show(session, makeUpload("/v1/inspect", upload), inspectionTable);
}

std::string sampleList(const Json& answer) {
    std::string text;
    for (const Json& sample : answer.value("samples", Json::array())) {
        const std::string name =
            sample.is_string() ? sample.get<std::string>() : textOf(sample, "name");
        const std::string words = sample.is_object() ? textOf(sample, "description") : "";
        text += name;
        if (!words.empty())
            text += std::string(name.size() < 16 ? 16 - name.size() : 1, ' ') + words;
        text += "\n";
    }
    return text;
}

Outcome<std::uint64_t> fetchSample(Session& session, const std::string& name,
                                   const std::string& out) {
    auto target = Target::open(out, session.console);
    if (!target) return tl::unexpected(target.error());
    const BodySink sink = target->sink();
    const std::string path = "/v1/samples/" + httplib::encode_uri_component(name);
    const auto response = session.transport.send(makeRequest("GET", path), &sink);
    if (!response) return tl::unexpected(response.error());
    const std::uint64_t size = target->size();
    if (auto committed = target->commit(); !committed) return tl::unexpected(committed.error());
    return size;
}

ExitCode runSample(Session& session) {
    const std::string& name = session.invocation.inputs.front();
    const std::string out = session.invocation.out.empty() ? name + ".vox" : session.invocation.out;
    const auto size = fetchSample(session, name, out);
    if (!size) return complain(session.console, name, size.error());
    if (!session.invocation.quiet && out != kStandardStream)
        session.console.err << name << " -> " << out << ", "
                            << bytesText(static_cast<double>(*size)) << "\n";
    return ExitCode::ok;
}

std::string healthLine(const Json& answer) {
    return textOf(answer, "name") + " " + textOf(answer, "version") + " answers\n";
}

ExitCode dispatch(Session& session, const std::vector<PlannedFile>& files) {
    switch (session.invocation.command) {
        case Command::regularize: return runRegularize(session, files);
        case Command::inspect: return runInspect(session);
        case Command::sample: return runSample(session);
        case Command::listSamples:
            return show(session, makeRequest("GET", "/v1/samples"), sampleList);
        case Command::options: return show(session, makeRequest("GET", "/v1/options"), optionTable);
        case Command::health: return show(session, makeRequest("GET", "/version"), healthLine);
    }
    return ExitCode::usage;
}

}  // namespace

ExitCode runCommand(const Invocation& invocation, Console& console, Interrupt& interrupt) {
    std::vector<PlannedFile> files;
    if (invocation.command == Command::regularize) {
        auto planned = planRegularize(invocation);
        if (!planned) return complain(console, {}, planned.error());
        files = *std::move(planned);
    }
    std::optional<LocalServer> own;
    Outcome<Endpoint> endpoint;
    if (invocation.server.empty()) {
        auto started = LocalServer::start(serverBeside(), interrupt);
        if (!started) return complain(console, {}, started.error());
        own.emplace(*std::move(started));
        endpoint = own->endpoint();
    } else {
        endpoint = parseEndpoint(invocation.server);
        if (!endpoint) return complain(console, {}, endpoint.error());
    }
    const ServerAccess server{*endpoint, invocation.apiKey, invocation.caFile};
    Session session{invocation, console, Transport(server, interrupt, invocation.retry)};
    session.transport.setDeadline(Clock::now() + invocation.timeout);
    return dispatch(session, files);
}

}  // namespace rivage::client
