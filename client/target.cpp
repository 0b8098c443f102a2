#include "client/target.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "client/plan.h"

namespace rivage::client {

Outcome<Target> Target::open(const std::string& path, Console& console,
                             const Interrupt& interrupt) {
    Target target(console);
    if (path != kStandardStream) {
        auto file = OutputFile::open(path, &interrupt);
        if (!file) return tl::unexpected(file.error());
        target.file_.emplace(*std::move(file));
        if (!target.file_->direct()) return target;
    } else if (console.outIsTerminal) {
        return fail(ExitCode::usage, "A terminal is no place for a binary file",
                    "use -o FILE, or send stdout to a file");
    }
    auto spool = SpoolFile::open();
    if (!spool) return tl::unexpected(spool.error());
    target.spool_.emplace(*std::move(spool));
    return target;
}

ByteStore Target::store() {
    return {[this] { return spool_ ? spool_->restart() : file_->restart(); },
            [this](std::string_view bytes) {
                return spool_ ? spool_->write(bytes) : file_->write(bytes);
            }};
}

/// The whole result goes where it can no longer be taken back.
bool Target::pour() {
    if (file_)
        return spool_->copyTo([this](std::string_view bytes) { return file_->write(bytes); });
    std::ostream& out = console_->out;
    const auto write = [&out](std::string_view bytes) { return static_cast<bool>(out << bytes); };
    return spool_->copyTo(write) && out.flush();
}

Outcome<void> Target::commit() {
    const bool poured = !spool_ || pour();
    if (file_) {
        if (auto committed = file_->commit(); !committed) return committed;
    }
    if (!poured)
        return fail(ExitCode::notWritten,
                    file_ ? "The result cannot be passed on" : "stdout cannot be written");
    return {};
}

Failure Target::explained(Failure failure) const {
    if (failure.exit != ExitCode::notWritten) return failure;
    if (auto reason = spool_ ? spool_->writable() : file_->writable(); !reason)
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
