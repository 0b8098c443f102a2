#include "client/commands/regularize.h"

#include <algorithm>
#include <filesystem>

#include "client/commands/batch.h"
#include "client/target.h"

namespace rivage::client {
Outcome<RegularizePlan> planRegularize(const Invocation& invocation) {
    std::vector<std::string> extensions{".vox", ".npy",    ".nrrd",   ".nii",
                                        ".vol", ".nii.gz", ".longvol"};
    const proto::Json options = proto::toJson(invocation.inForce);
    if (textOf(options, "format") == "raw") extensions = {".raw"};
    auto inputs = findInputs(invocation.inputs, extensions, invocation.watch);
    if (!inputs) return tl::unexpected(inputs.error());
    auto files = planFiles(*inputs, invocation.out, textOf(options, "output"));
    if (!files) return tl::unexpected(files.error());
    const auto usesStdio = [](const PlannedFile& file) {
        return file.output == kStandardStream || file.input == kStandardStream;
    };
    const auto toStdout = [](const PlannedFile& file) { return file.output == kStandardStream; };
    if (invocation.json && std::any_of(files->begin(), files->end(), toStdout))
        return fail(ExitCode::usage, "stdout cannot take both",
                    "--json prints there, so the result needs -o FILE");
    if (invocation.watch && std::any_of(files->begin(), files->end(), usesStdio))
        return fail(ExitCode::usage, "Only files can be watched", "'-' cannot");
    return RegularizePlan{*std::move(inputs), *std::move(files)};
}

Outcome<void> makeFolders(const Invocation& invocation, const RegularizePlan& plan) {
    // A single file that names a folder which is not there is a slip, a tree is made as it is.
    const bool tree = plan.inputs.many || invocation.out.ends_with('/');
    for (const PlannedFile& file : plan.files) {
        if (!tree || invocation.out.empty()) continue;
        if (auto made = makeFolderOf(file.output); !made) return made;
    }
    return {};
}

ExitCode runRegularize(Session& session, const RegularizePlan& plan) {
    const auto start = Clock::now();
    const auto outcomes = convertFiles(session, plan.files);
    const std::chrono::duration<double> time = Clock::now() - start;
    summarize(session, outcomes, time.count());
    if (session.interrupt.requested()) return ExitCode::cancelled;
    const ExitCode exit = firstFailure(outcomes);
    return exit == ExitCode::ok && !plan.inputs.unread.empty() ? ExitCode::usage : exit;
}

}  // namespace rivage::client
