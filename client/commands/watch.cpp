#include <sys/stat.h>

#include <filesystem>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "client/commands/batch.h"
#include "client/commands/regularize.h"
#include "client/folder_watch.h"

namespace rivage::client {
namespace {

/// When a server that was not there, or was full, is asked again.
constexpr std::chrono::milliseconds kAskAgain{5'000};
constexpr std::chrono::milliseconds kNoReason{3'600'000};

/// What tells one content of a file from the next, without reading it.
using Print = std::tuple<ino_t, off_t, time_t, long>;

std::optional<Print> printOf(const std::string& path) {
    struct stat status {};
    if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
    return Print{status.st_ino, status.st_size, status.st_mtim.tv_sec, status.st_mtim.tv_nsec};
}

/// The files of a watched run, and which content of each was converted last.
class Watch {
public:
    Watch(Session& session, FolderWatch folders)
        : session_(session), folders_(std::move(folders)) {}

    ExitCode run(RegularizePlan plan) {
        for (;;) {
            if (auto watched = watchFolders(plan); !watched) return say(watched.error());
            const bool again = convertChanged(plan);
            if (session_.interrupt.requested()) return busy_ ? ExitCode::cancelled : ExitCode::ok;
            sayThatItWaits();
            folders_.wait(session_.interrupt, again ? kAskAgain : kNoReason);
            if (session_.interrupt.requested()) return ExitCode::ok;
            auto next = planRegularize(session_.invocation);
            if (next)
                plan = *std::move(next);
            else
                say(next.error());
        }
    }

private:
    Outcome<void> watchFolders(const RegularizePlan& plan) {
        for (const std::string& folder : plan.inputs.folders)
            if (auto added = folders_.add(folder, true); !added) return added;
        for (const PlannedFile& file : plan.files) {
            const std::string folder = std::filesystem::path(file.input).parent_path().string();
            if (auto added = folders_.add(folder.empty() ? "." : folder, false); !added)
                return added;
        }
        return {};
    }

    /// @return  whether some have to be tried again although they do not change
    bool convertChanged(const RegularizePlan& plan) {
        std::vector<PlannedFile> changed;
        for (const PlannedFile& file : plan.files) {
            const auto print = printOf(file.input);
            const auto known = prints_.find(file.input);
            const bool first = known == prints_.end() && !complete_;
            if (!print && !first) continue;  // removed
            if (known != prints_.end() && known->second == print) continue;
            prints_[file.input] = print;
            changed.push_back(file);
        }
        complete_ = true;
        if (changed.empty()) return false;
        if (auto made = makeFolders(session_.invocation, plan); !made) say(made.error());
        const auto start = Clock::now();
        busy_ = true;
        const auto outcomes = convertFiles(session_, changed);
        busy_ = session_.interrupt.requested() && firstFailure(outcomes) == ExitCode::cancelled;
        const std::chrono::duration<double> time = Clock::now() - start;
        summarize(session_, outcomes, time.count());
        return forget(changed, outcomes);
    }

    /// Files that met no server, or a full one, count as never converted.
    bool forget(const std::vector<PlannedFile>& files, const std::vector<FileOutcome>& outcomes) {
        bool any = false;
        for (std::size_t i = 0; i < files.size(); ++i) {
            const ExitCode exit = outcomes[i].exit;
            if (outcomes[i].done && exit != ExitCode::unreachable && exit != ExitCode::busy)
                continue;
            prints_.erase(files[i].input);
            any = true;
        }
        return any;
    }

    void sayThatItWaits() {
        if (session_.invocation.quiet || std::exchange(saidSo_, true)) return;
        session_.console.err << "watching for changes; Ctrl-C ends it\n" << std::flush;
    }

    ExitCode say(const Failure& failure) {
        return complain(session_.invocation, session_.console, {}, failure);
    }

    Session& session_;
    FolderWatch folders_;
    std::map<std::string, std::optional<Print>> prints_;
    bool complete_ = false;  ///< every file was looked at once
    bool saidSo_ = false;
    bool busy_ = false;  ///< the stop broke off a conversion
};

}  // namespace

ExitCode runWatch(Session& session, const RegularizePlan& plan) {
    auto folders = FolderWatch::open();
    if (!folders) return complain(session.invocation, session.console, {}, folders.error());
    return Watch(session, *std::move(folders)).run(plan);
}

}  // namespace rivage::client
