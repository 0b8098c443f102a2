#include "client/load/output_folder.h"

#include <filesystem>
#include <system_error>

#include "client/output_file.h"

namespace rivage::client::load {

Outcome<void> writeFolder(const std::string& folder,
                          const std::vector<std::pair<std::string, std::string>>& files) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) return fail(ExitCode::notWritten, "The folder cannot be made", error.message());
    for (const auto& [name, text] : files) {
        auto file = OutputFile::open((std::filesystem::path(folder) / name).string());
        if (!file) return tl::unexpected(file.error());
        file->write(text);
        if (auto done = file->commit(); !done) return done;
    }
    return {};
}

}  // namespace rivage::client::load
