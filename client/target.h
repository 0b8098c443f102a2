#pragma once

#include <optional>
#include <string>

#include "client/console.h"
#include "client/download.h"
#include "client/output_file.h"
#include "client/spool_file.h"

namespace rivage::client {

/// The place of one result: a file that appears when it is whole; or stdout, a pipe or a device, which
/// get the first byte then.
class Target {
public:
    /// @param path  "-" is stdout
    /// @errors usage if stdout is a terminal; notWritten; cancelled
    static Outcome<Target> open(const std::string& path, Console& console,
                                const Interrupt& interrupt);

    /// Where the bytes of the result go; to be used while the target stays where it is.
    [[nodiscard]] ByteStore store();
    [[nodiscard]] std::uint64_t size() const { return spool_ ? spool_->size() : file_->size(); }
    /// @errors notWritten
    Outcome<void> commit();
    /// The failure of a download into this target, with the reason of the system if it is this
    /// target that would not take the bytes.
    [[nodiscard]] Failure explained(Failure failure) const;

private:
    explicit Target(Console& console) : console_(&console) {}
    Console* console_;
    bool pour();
    std::optional<OutputFile> file_;  ///< none for stdout
    std::optional<SpoolFile> spool_;  ///< for what takes nothing back
};

/// Makes the folders above a file.
/// @errors notWritten
Outcome<void> makeFolderOf(const std::string& path);

}  // namespace rivage::client
