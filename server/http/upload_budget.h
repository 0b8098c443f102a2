#pragma once

#include <atomic>
#include <cstdint>

namespace rivage::server {

/// Bytes that all uploads in flight may hold together, and how many were refused for it. Safe to
/// use from several threads.
class UploadBudget {
public:
    /// What one upload holds; given back at its end.
    class Share {
    public:
        explicit Share(UploadBudget& budget) : budget_(budget) {}
        ~Share() { budget_.used_ -= held_; }
        Share(const Share&) = delete;
        Share& operator=(const Share&) = delete;
        /// Holds at least so many bytes from now on. @return false if they are not there
        [[nodiscard]] bool grow(std::uint64_t bytes);

    private:
        UploadBudget& budget_;
        std::uint64_t held_ = 0;
    };

    [[nodiscard]] std::uint64_t used() const { return used_; }
    [[nodiscard]] std::uint64_t refused() const { return refused_; }

    std::uint64_t limit = ~std::uint64_t{0};  ///< set before the first upload

private:
    std::atomic<std::uint64_t> used_{0};
    std::atomic<std::uint64_t> refused_{0};
};

}  // namespace rivage::server
