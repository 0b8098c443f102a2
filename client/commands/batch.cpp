#include "client/commands/batch.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <filesystem>
#include <new>
#include <system_error>
#include <thread>
#include <utility>

#include "client/conversion.h"
#include "client/inputs.h"
#include "client/printable.h"
#include "client/progress.h"
#include "client/report_table.h"
#include "client/target.h"

namespace rivage::client {
namespace {

using proto::Json;

/// What a conversion leaves behind beside its file.
struct Converted {
    Conversion conversion;
    std::uint64_t bytes = 0;
};

Outcome<Converted> convert(Session& session, Transport& transport, const PlannedFile& file,
                           const JobWatch& watch) {
    auto bytes = readInput(file.input, session.console, session.interrupt);
    if (!bytes) return tl::unexpected(bytes.error());
    if (bytes->empty()) return fail(ExitCode::refused, "The file is empty");
    const std::string start = bytes->substr(0, kSignatureBytes);
    auto target = Target::open(file.output, session.console, session.interrupt);
    if (!target) return tl::unexpected(target.error());
    const std::string name =
        file.input == kStandardStream ? "" : std::filesystem::path(file.input).filename().string();
    const Upload upload{*std::move(bytes), session.invocation.options, name};
    const ByteStore store = target->store();
    auto conversion = convertGrid(transport, upload, store, watch);
    if (!conversion)
        return tl::unexpected(
            inWordsOfFiles(file.input, start, target->explained(conversion.error())));
    Converted converted{*std::move(conversion), target->size()};
    if (auto committed = target->commit(); !committed) {
        committed.error().job = converted.conversion.job;
        return tl::unexpected(committed.error());
    }
    return converted;
}

/// A bar on the board for as long as a file is worked on, however that ends.
class Bar {
public:
    Bar(ProgressBoard& board, const std::string& name) : board_(board), line_(board.begin(name)) {}
    ~Bar() { end(); }
    Bar(const Bar&) = delete;
    Bar& operator=(const Bar&) = delete;
    void update(const JobProgress& progress) { board_.update(line_, progress); }
    /// @return  the seconds that it stood
    double end() {
        if (!std::exchange(ended_, true)) seconds_ = board_.end(line_);
        return seconds_;
    }

private:
    ProgressBoard& board_;
    std::size_t line_;
    bool ended_ = false;
    double seconds_ = 0;
};

/// The files of a batch, and the threads that take one after the other.
class Batch {
public:
    Batch(Session& session, const std::vector<PlannedFile>& files)
        : session_(session),
          files_(files),
          outcomes_(files.size()),
          options_(proto::toJson(session.invocation.inForce.conversion)),
          board_(session.console, session.invocation.quiet, files.size()) {}

    std::vector<FileOutcome> run() {
        const std::size_t workers =
            std::clamp<std::size_t>(session_.invocation.workers, 1, files_.size());
        std::vector<std::thread> threads;
        try {
            for (std::size_t i = 1; i < workers; ++i) threads.emplace_back([this] { work(); });
        } catch (const std::system_error&) {
            // The system gives no more threads: fewer do.
        }
        work();
        for (std::thread& thread : threads) thread.join();
        return std::move(outcomes_);
    }

private:
    void work() {
        for (std::size_t i = next_++; i < files_.size() && !over(); i = next_++) {
            FileOutcome& outcome = outcomes_[i] = safely(files_[i]);
            outcome.done = true;
            const bool failed = outcome.exit != ExitCode::ok;
            if (outcome.noServer || (failed && session_.invocation.stopOnError)) over_ = true;
        }
    }

    [[nodiscard]] bool over() const { return over_ || session_.interrupt.requested(); }

    /// What a library throws, memory that runs out above all, is the end of one file, not of all.
    FileOutcome safely(const PlannedFile& file) {
        try {
            return one(file);
        } catch (const std::bad_alloc&) {
            return failed(file, failureWith(ExitCode::failed, "There is not enough memory"), 0);
        } catch (const std::exception& error) {
            return failed(
                file, failureWith(ExitCode::failed, "The conversion broke off", error.what()), 0);
        }
    }

    FileOutcome one(const PlannedFile& file) {
        if (session_.invocation.ifNewer && isUpToDate(file, options_)) {
            tellJson(file, {{"skipped", true}}, Json::object());
            return {.skipped = true};
        }
        Bar bar(board_, file.input);
        const JobWatch watch{[&](const JobProgress& progress) { bar.update(progress); },
                             board_.lively()};
        Transport transport = session_.connect();
        const auto converted = convert(session_, transport, file, watch);
        const double seconds = bar.end();
        if (!converted) return failed(file, converted.error(), seconds);

        const auto& [conversion, bytes] = *converted;
        std::string words = painted(session_.console, Tone::good, "->") + " " +
                            printable(file.output) + ", " + bytesText(static_cast<double>(bytes)) +
                            ", " + secondsText(seconds);
        if (files_.size() == 1 && !session_.invocation.json && !session_.invocation.watch)
            words += "\n" + reportTable(conversion.report);
        tell(file, words, {{"job", conversion.job}, {"bytes", bytes}, {"seconds", seconds}},
             conversion.report);
        return {.bytes = bytes};
    }

    FileOutcome failed(const PlannedFile& file, const Failure& failure, double seconds) {
        Json run{{"exit", static_cast<int>(failure.exit)}, {"seconds", seconds}};
        if (!failure.job.empty()) run["job"] = failure.job;
        tellJson(file, std::move(run), failure.problem);
        board_.say(session_.console.err, complaintText(session_, file.input, failure, file.output));
        return {.exit = failure.exit,
                .noServer = failure.exit == ExitCode::unreachable && failure.job.empty()};
    }

    void tell(const PlannedFile& file, const std::string& words, Json run, const Json& document) {
        tellJson(file, std::move(run), document);
        if (session_.invocation.quiet) return;
        board_.say(session_.console.err,
                   printable(file.input) + " " + words + (words.ends_with('\n') ? "" : "\n"));
    }

    /// The report or the problem, with what this run adds to it.
    void tellJson(const PlannedFile& file, Json run, Json document) {
        if (!session_.invocation.json) return;
        run["input"] = file.input;
        run["output"] = file.output;
        document["run"] = std::move(run);
        board_.say(session_.console.out, jsonLine(document));
    }

    Session& session_;
    const std::vector<PlannedFile>& files_;
    std::vector<FileOutcome> outcomes_;
    const Json options_;  ///< as a result tells them
    ProgressBoard board_;
    std::atomic<std::size_t> next_{0};
    std::atomic<bool> over_{false};
};

}  // namespace

std::vector<FileOutcome> convertFiles(Session& session, const std::vector<PlannedFile>& files) {
    return Batch(session, files).run();
}

void summarize(Session& session, const std::vector<FileOutcome>& outcomes, double seconds) {
    const bool skippedAny = std::any_of(outcomes.begin(), outcomes.end(),
                                        [](const FileOutcome& one) { return one.skipped; });
    if (session.invocation.quiet || (outcomes.size() < 2 && !skippedAny)) return;
    std::size_t converted = 0;
    std::size_t failed = 0;
    std::size_t skipped = 0;
    std::size_t left = 0;
    std::uint64_t bytes = 0;
    for (const FileOutcome& outcome : outcomes) {
        bytes += outcome.bytes;
        ++(!outcome.done                  ? left
           : outcome.skipped              ? skipped
           : outcome.exit == ExitCode::ok ? converted
                                          : failed);
    }
    std::string text = std::to_string(converted) + " converted";
    if (failed > 0) text += ", " + std::to_string(failed) + " failed";
    if (skipped > 0) text += ", " + std::to_string(skipped) + " up to date";
    if (left > 0) text += ", " + std::to_string(left) + " not tried";
    session.console.err << text << "; " << bytesText(static_cast<double>(bytes)) << " in "
                        << secondsText(seconds) << "\n"
                        << std::flush;
}

ExitCode firstFailure(const std::vector<FileOutcome>& outcomes) {
    for (const FileOutcome& outcome : outcomes)
        if (outcome.done && outcome.exit != ExitCode::ok) return outcome.exit;
    return ExitCode::ok;
}

}  // namespace rivage::client
