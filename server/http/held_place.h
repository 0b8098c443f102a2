#pragma once

#include <atomic>
#include <cstddef>

namespace rivage::server {

/// One of a bounded number of places, as long as it lives, if there was one left.
class HeldPlace {
public:
    HeldPlace(std::atomic<std::size_t>& taken, std::size_t limit)
        : taken_(taken), held_(taken++ < limit) {}
    ~HeldPlace() { --taken_; }
    HeldPlace(const HeldPlace&) = delete;
    HeldPlace& operator=(const HeldPlace&) = delete;
    [[nodiscard]] bool held() const { return held_; }

private:
    std::atomic<std::size_t>& taken_;
    const bool held_;
};

}  // namespace rivage::server
