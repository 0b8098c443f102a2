#include <algorithm>
#include <filesystem>

#include "client/commands/session.h"
#include "client/inputs.h"
#include "client/job_calls.h"
#include "client/printable.h"
#include "client/progress.h"
#include "client/target.h"

namespace rivage::client {
namespace {

using proto::Json;

/// What one command does with one job; the answer is shown.
using JobAction = Outcome<Json> (*)(Session&, const std::string& id, ProgressBoard&);

std::string columns(const std::string& id, const std::string& state, const std::string& stage,
                    const std::string& done, const std::string& created, const std::string& name) {
    std::string line;
    const auto add = [&line](const std::string& text, std::size_t width) {
        line += text + std::string(text.size() < width ? width - text.size() : 0, ' ');
    };
    add(id, 36);
    add("  " + state, 12);
    add(stage, 11);
    line += std::string(done.size() < 5 ? 5 - done.size() : 0, ' ') + done;
    return line + "  " + created + "  " + name;
}

/// A time of the wire to the second, with its zone: "2026-01-02T03:04:05Z".
std::string timeText(const std::string& time) {
    const std::size_t point = time.find('.');
    const std::size_t zone = time.find_first_not_of("0123456789", std::min(point, time.size()) + 1);
    if (point == std::string::npos || zone == std::string::npos) return time;
    return time.substr(0, point) + time.substr(zone);
}

std::string jobLine(const Json& job) {
    std::string line = columns(textOf(job, "id"), textOf(job, "state"), textOf(job, "stage"),
                               percentText(numberOf(job, "progress")),
                               timeText(textOf(job, "created")), textOf(job, "name"));
    if (const JobProgress progress = progressOf(job); progress.queuePosition)
        line += "  " + countText(*progress.queuePosition) + " ahead";
    const auto error = job.find("error");
    if (error != job.end() && error->is_object()) line += "  " + textOf(*error, "title");
    return printable(line) + "\n";
}

void show(Session& session, ProgressBoard& board, const Json& job) {
    board.say(session.console.out, session.invocation.json ? jsonLine(job) : jobLine(job));
}

/// Does something with every job that was named; the exit code is that of the first that failed.
ExitCode forEachJob(Session& session, JobAction action) {
    ProgressBoard board(session.console, session.invocation.quiet,
                        session.invocation.inputs.size());
    ExitCode first = ExitCode::ok;
    for (const std::string& id : session.invocation.inputs) {
        if (session.interrupt.requested()) return ExitCode::cancelled;
        const Outcome<Json> done = action(session, id, board);
        if (done) continue;
        if (session.invocation.json) board.say(session.console.out, jsonLine(done.error().problem));
        board.say(session.console.err, complaintText(session, id, done.error(), {}));
        if (first == ExitCode::ok) first = done.error().exit;
        if (done.error().exit == ExitCode::unreachable) break;
    }
    return first;
}

Outcome<Json> status(Session& session, const std::string& id, ProgressBoard& board) {
    Transport transport = session.connect();
    auto job = getJob(transport, id);
    if (job) show(session, board, *job);
    return job;
}

/// A job that has ended. Giving up the waiting leaves it alone.
Outcome<Json> ended(Session& session, Transport& transport, const std::string& id,
                    ProgressBoard& board) {
    const std::size_t line = board.begin(id);
    auto job = followJob(
        transport, id,
        {[&](const JobProgress& progress) { board.update(line, progress); }, board.lively()});
    board.end(line);
    if (!job && job.error().exit != ExitCode::refused && !session.interrupt.requested())
        job.error().job = id;
    return job;
}

Outcome<Json> wait(Session& session, const std::string& id, ProgressBoard& board) {
    Transport transport = session.connect();
    auto job = ended(session, transport, id, board);
    if (!job) return job;
    show(session, board, *job);
    return reportOf(*job);
}

std::string endText(const std::string& state) {
    if (state == "succeeded") return "it succeeded, and its result stays";
    if (state == "failed") return "it failed";
    return state == "canceled" ? "it was cancelled" : state;
}

Outcome<Json> cancel(Session& session, const std::string& id, ProgressBoard& board) {
    Transport transport = session.connect();
    auto job = getJob(transport, id);
    if (!job) return job;
    // The same request would make the server forget a job that has ended, and its result.
    const std::string state = textOf(*job, "state");
    const bool open = state == "queued" || state == "running";
    if (open) {
        const auto deleted = transport.send(makeDeletion(id));
        if (!deleted) return tl::unexpected(deleted.error());
        (*job)["state"] = "canceled";
    }
    show(session, board, *job);
    if (!open && !session.invocation.quiet)
        board.say(session.console.err,
                  id + " had already ended: " + printable(endText(state)) + "\n");
    return job;
}

/// Where the result of a job goes: named by its id, since several jobs may have the same name.
std::string placeOf(const Session& session, const std::string& id, const Json& job) {
    const std::string& out = session.invocation.out;
    std::error_code ignored;
    const bool folder = out.ends_with('/') || std::filesystem::is_directory(out, ignored);
    if (!out.empty() && !folder) return out;
    const auto options = job.find("options");
    const std::string format =
        options != job.end() && options->is_object() ? textOf(*options, "output") : std::string();
    const std::string name = id + "." + (format.empty() ? "glb" : format);
    return out.empty() ? name : (std::filesystem::path(out) / name).string();
}

Outcome<Json> fetch(Session& session, const std::string& id, ProgressBoard& board) {
    Transport transport = session.connect();
    auto job = ended(session, transport, id, board);
    if (!job) return job;
    auto report = reportOf(*job);
    if (!report) return report;
    const std::string place = placeOf(session, id, *job);
    if (session.invocation.out.ends_with('/'))
        if (auto made = makeFolderOf(place); !made) return tl::unexpected(made.error());
    auto target = Target::open(place, session.console, session.interrupt);
    if (!target) return tl::unexpected(target.error());
    const ByteStore store = target->store();
    if (auto fetched = fetchResult(transport, id, store); !fetched)
        return tl::unexpected(target->explained(fetched.error()));
    const std::uint64_t size = target->size();
    if (auto committed = target->commit(); !committed) return tl::unexpected(committed.error());
    if (session.invocation.json && place != kStandardStream) {
        (*report)["run"] = {{"job", id}, {"output", place}, {"bytes", size}};
        board.say(session.console.out, jsonLine(*report));
    }
    if (!session.invocation.quiet)
        board.say(session.console.err, id + " -> " + printable(place) + ", " +
                                           bytesText(static_cast<double>(size)) + "\n");
    return report;
}

}  // namespace

ExitCode runJobsList(Session& session) {
    Transport transport = session.connect();
    const auto jobs =
        listJobs(transport, {session.invocation.jobState, session.invocation.jobLimit});
    if (!jobs) return complain(session.invocation, session.console, {}, jobs.error());
    if (session.console.outIsTerminal && !session.invocation.json && !jobs->empty())
        session.console.out << columns("JOB", "STATE", "STAGE", "DONE", "CREATED", "NAME") << "\n";
    for (const Json& job : *jobs)
        session.console.out << (session.invocation.json ? jsonLine(job) : jobLine(job));
    return ExitCode::ok;
}

ExitCode runJobsStatus(Session& session) { return forEachJob(session, status); }

ExitCode runJobsWait(Session& session) { return forEachJob(session, wait); }

ExitCode runJobsCancel(Session& session) { return forEachJob(session, cancel); }

ExitCode runJobsFetch(Session& session) {
    const std::string& out = session.invocation.out;
    std::error_code ignored;
    const bool folder = out.ends_with('/') || std::filesystem::is_directory(out, ignored);
    if (session.invocation.inputs.size() > 1 && !out.empty() && !folder)
        return complain(session.invocation, session.console, {},
                        failureWith(ExitCode::usage, "Where should the results go",
                                    "several results need a folder after -o: " + out +
                                        " is none (a new one ends in /)"));
    return forEachJob(session, fetch);
}

}  // namespace rivage::client
