#include "server/jobs/idempotency.h"

#include <algorithm>

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

constexpr std::size_t kLongestKey = 255;

}  // namespace

core::Result<std::string> readIdempotencyKey(const std::string& header) {
    const bool quoted = header.size() >= 2 && header.front() == '"' && header.back() == '"';
    const std::string text = quoted ? header.substr(1, header.size() - 2) : header;
    const bool plain = std::all_of(text.begin(), text.end(), [&](char c) {
        return c > ' ' && c < 0x7f && c != '"' && c != '\\' && (quoted || (c != ',' && c != ';'));
    });
    if (!plain || text.empty() || text.size() > kLongestKey)
        return fail(core::Error{ErrorCode::malformedRequest,
                                "an Idempotency-Key is a quoted string of 1 to 255 visible ASCII "
                                "characters without quotes and backslashes",
                                "/headers/idempotency-key", kLongestKey, text.size()});
    return text;
}

core::Result<IdempotencyKeys::Lookup> IdempotencyKeys::claim(const std::string& owner,
                                                             const std::string& key) {
    const std::lock_guard lock(mutex_);
    Entry& entry = entries_[{owner, key}];
    if (entry.claimed)
        return fail(ErrorCode::keyInProgress,
                    "another request with this Idempotency-Key is still being received",
                    "/headers/idempotency-key");
    if (auto job = entry.job.lock()) return Lookup{std::move(job), {}};
    entry.claimed = true;
    return Lookup{{}, Claim(this, {owner, key})};
}

void IdempotencyKeys::remember(const std::shared_ptr<Job>& job) {
    if (!job->facts().idempotencyKey.empty())
        set({job->facts().owner, job->facts().idempotencyKey}, job);
}

void IdempotencyKeys::set(const Claim::Name& name, const std::shared_ptr<Job>& job) {
    const std::lock_guard lock(mutex_);
    entries_[name] = {false, job};
}

void IdempotencyKeys::drop(const Claim::Name& name) {
    const std::lock_guard lock(mutex_);
    entries_.erase(name);
}

void IdempotencyKeys::sweep() {
    const std::lock_guard lock(mutex_);
    std::erase_if(entries_, [](const auto& item) {
        return !item.second.claimed && item.second.job.expired();
    });
}

}  // namespace rivage::server
