#include "server/http/upload_budget.h"

namespace rivage::server {

bool UploadBudget::Share::grow(std::uint64_t bytes) {
    if (bytes <= held_) return true;
    const std::uint64_t more = bytes - held_;
    std::uint64_t used = budget_.used_;
    do {
        if (more > budget_.limit || used > budget_.limit - more) {
            ++budget_.refused_;
            return false;
        }
    } while (!budget_.used_.compare_exchange_weak(used, used + more));
    held_ = bytes;
    return true;
}

}  // namespace rivage::server
