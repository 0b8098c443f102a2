#include "client/commands/session.h"
#include "client/inputs.h"
#include "client/option_help.h"
#include "client/printable.h"
#include "client/progress.h"
#include "client/report_table.h"
#include "client/target.h"
#include "client/upload.h"

namespace rivage::client {
namespace {

using proto::Json;

ExitCode stop(Session& session, const std::string& about, const Failure& failure) {
    return complain(session.invocation, session.console, about, failure);
}

/// An answer that is a JSON document, printed as JSON or as `table` makes it.
template <typename Table>
ExitCode print(Session& session, const httplib::Response& response, Table table) {
    const Json json = readAnswer(response.body);
    if (!json.is_object())
        return stop(session, {},
                    failureWith(ExitCode::failed, "The server's answer is not understood",
                                "expected a JSON object"));
    session.console.out << (session.invocation.json ? jsonLine(json) : table(json)) << std::flush;
    return ExitCode::ok;
}

ExitCode show(Session& session, const char* path, std::string (*table)(const Json&)) {
    const auto response = session.connect().send(makeRequest("GET", path));
    if (!response) return stop(session, {}, response.error());
    return print(session, *response, table);
}

std::string sampleList(const Json& answer) {
    std::string text;
    for (const Json& sample : answer.value("samples", Json::array())) {
        const std::string name =
            printable(sample.is_string() ? sample.get<std::string>() : textOf(sample, "name"));
        const std::string words =
            printable(sample.is_object() ? textOf(sample, "description") : "");
        text += name;
        if (!words.empty())
            text += std::string(name.size() < 16 ? 16 - name.size() : 1, ' ') + words;
        text += "\n";
    }
    return text;
}

Outcome<std::uint64_t> fetchSample(Session& session, const std::string& name,
                                   const std::string& out) {
    auto target = Target::open(out, session.console, session.interrupt);
    if (!target) return tl::unexpected(target.error());
    const ByteStore store = target->store();
    Transport transport = session.connect();
    const auto fetched =
        download(transport, "/v1/samples/" + httplib::encode_uri_component(name), store);
    if (!fetched) return tl::unexpected(target->explained(fetched.error()));
    const std::uint64_t size = target->size();
    if (auto committed = target->commit(); !committed) return tl::unexpected(committed.error());
    return size;
}

std::string healthLine(const Json& answer) {
    return printable(textOf(answer, "name") + " " + textOf(answer, "version")) + " answers\n";
}

}  // namespace

ExitCode runInspect(Session& session) {
    const std::string& input = session.invocation.inputs.front();
    auto bytes = readInput(input, session.console, session.interrupt);
    if (!bytes) return stop(session, input, bytes.error());
    if (bytes->empty())
        return stop(session, input, failureWith(ExitCode::refused, "The file is empty"));
    const std::string start = bytes->substr(0, kSignatureBytes);
    const Upload upload{*std::move(bytes), session.invocation.options};
    const auto response = session.connect().send(makeUpload("/v1/inspect", upload));
    if (!response) return stop(session, input, inWordsOfFiles(input, start, response.error()));
    return print(session, *response, inspectionTable);
}

ExitCode runSample(Session& session) {
    const std::string& name = session.invocation.inputs.front();
    const std::string out = session.invocation.out.empty() ? name + ".vox" : session.invocation.out;
    const auto size = fetchSample(session, name, out);
    if (!size) return stop(session, name, size.error());
    if (session.invocation.json && out != kStandardStream)
        session.console.out << jsonLine({{"sample", name}, {"output", out}, {"bytes", *size}})
                            << std::flush;
    if (!session.invocation.quiet && out != kStandardStream)
        session.console.err << printable(name) << " -> " << printable(out) << ", "
                            << bytesText(static_cast<double>(*size)) << "\n";
    return ExitCode::ok;
}

ExitCode runListSamples(Session& session) { return show(session, "/v1/samples", sampleList); }

ExitCode runOptions(Session& session) {
    if (session.invocation.inputs.empty()) return show(session, "/v1/options", optionTable);
    const auto response = session.connect().send(makeRequest("GET", "/v1/options"));
    if (!response) return stop(session, {}, response.error());
    const Json answer = readAnswer(response->body);
    const auto help = explainOption(answer.is_object() ? answer : Json::object(),
                                    session.invocation.inputs.front());
    if (!help) return stop(session, {}, help.error());
    session.console.out << (session.invocation.json ? jsonLine(help->json) : help->text);
    return ExitCode::ok;
}

ExitCode runHealth(Session& session) { return show(session, "/version", healthLine); }

}  // namespace rivage::client
