#pragma once

#include <httplib.h>

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/keys/api_keys.h"
#include "server/keys/quota.h"

namespace rivage::server {

struct Service;

/// Who calls. Without keys everybody is the same nameless caller.
struct Caller {
    std::string name = {};
    QuotaLimits quota = {};
};

/// Who may call: the keys in force, and what their holders have used up. Safe to use from several
/// threads; the keys may be exchanged while requests are served.
class Access {
public:
    using WallClock = std::function<proto::WallTime()>;
    explicit Access(std::shared_ptr<const KeyRing> ring, QuotaBook::Now now = Clock::now,
                    WallClock wallNow = std::chrono::system_clock::now);

    /// Reads the file again; a broken one leaves the keys as they are. @errors as `KeyRing::load`
    core::Result<void> reload(const std::string& path);

    /// Who presents a key, `Authorization: Bearer KEY` or `X-API-Key: KEY`, once.
    /// @errors unauthorized without a known key; forbidden if it is disabled or has expired
    [[nodiscard]] core::Result<Caller> identify(const httplib::Request& request) const;
    Charge charge(const Caller& caller) { return quotas_.take(caller.name, caller.quota); }

    /// A place for one more upload of a caller who may have `quota.jobs` jobs; null if there is
    /// none. Whoever holds it has one job more than `unfinished` counts.
    /// @param unfinished  jobs of the caller that have not ended, counted under a lock
    [[nodiscard]] std::shared_ptr<void> reserveJob(const Caller& caller,
                                                   const std::function<std::size_t()>& unfinished);

private:
    using Clock = std::chrono::steady_clock;
    [[nodiscard]] std::shared_ptr<const KeyRing> ring() const;

    const WallClock wallNow_;
    QuotaBook quotas_;
    mutable std::mutex mutex_;
    std::shared_ptr<const KeyRing> ring_;
    std::map<std::string, std::size_t> uploading_;
};

/// Whether this path needs a key, if the server has keys: all of /v1 does.
[[nodiscard]] bool needsKey(const std::string& path);

/// Decides who calls and whether the quota allows it, once for each request however often it is
/// asked; an upload also takes one of the caller's jobs. The caller is kept with the response.
/// @return true if the answer is 401, 403 or 429; it is then written
bool refusesCaller(Service& service, const httplib::Request& request, httplib::Response& response,
                   bool upload);

/// Who was found to call.
[[nodiscard]] const Caller& callerOf(const httplib::Response& response);

/// An upload has become a job, which is counted from now on by itself.
void releaseUpload(httplib::Response& response);

}  // namespace rivage::server
