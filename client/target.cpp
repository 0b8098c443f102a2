#include "client/target.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "client/plan.h"

namespace rivage::client {

Outcome<Target> Target::open(const std::string& path, Console& console,
                             const Interrupt& interrupt) {
    Target target(console);
    if (path == kStandardStream) {
        if (console.outIsTerminal)
            return fail(ExitCode::usage, "A terminal is no place for a binary file",
                        "use -o FILE, or send stdout to a file");
        auto spool = SpoolFile::open();
        if (!spool) return tl::unexpected(spool.error());
        target.spool_.emplace(*std::move(spool));
        return target;
    }
    auto file = OutputFile::open(path, &interrupt);
    if (!file) return tl::unexpected(file.error());
    target.file_.emplace(*std::move(file));
    return target;
}

ByteStore Target::store() {
    return {[this] { return file_ ? file_->restart() : spool_->restart(); },
            [this](std::string_view bytes) {
                return file_ ? file_->write(bytes) : spool_->write(bytes);
            }};
}

Outcome<void> Target::commit() {
    if (file_) return file_->commit();
    if (!spool_->copyTo(console_->out))
        return fail(ExitCode::notWritten, "stdout cannot be written");
    return {};
}

Failure Target::explained(Failure failure) const {
    if (failure.exit != ExitCode::notWritten) return failure;
    if (auto reason = file_ ? file_->writable() : spool_->writable(); !reason)
        failure.problem = reason.error().problem;
    return failure;
}

Outcome<void> makeFolderOf(const std::string& path) {
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    std::error_code error;
    if (!folder.empty()) std::filesystem::create_directories(folder, error);
    if (error)
        return fail(ExitCode::notWritten, "The folder cannot be made",
                    folder.string() + ": " + error.message());
    return {};
}

}  // namespace rivage::client
