#include "server/http/access.h"

#include <utility>

#include "server/http/exchange.h"

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

constexpr const char* kCaller = "caller";
constexpr const char* kUpload = "upload-of-caller";

/// The key in the headers, or nothing if there is none, or more than one.
std::string presentedKey(const httplib::Request& request) {
    const std::size_t bearers = request.get_header_value_count("Authorization");
    const std::size_t keys = request.get_header_value_count("X-API-Key");
    if (bearers + keys != 1) return {};
    if (keys == 1) return request.get_header_value("X-API-Key");
    constexpr std::string_view kScheme = "bearer ";
    const std::string value = request.get_header_value("Authorization");
    if (value.size() <= kScheme.size()) return {};
    for (std::size_t i = 0; i < kScheme.size(); ++i)
        if ((value[i] | 0x20) != (kScheme[i] | 0x20)) return {};
    const std::size_t begin = value.find_first_not_of(' ', kScheme.size());
    return begin == std::string::npos ? std::string() : value.substr(begin);
}

void refuseByQuota(Service& service, httplib::Response& response, const std::string& policy,
                   const std::string& state, std::chrono::seconds retryAfter,
                   const core::Error& error) {
    ++service.rejectedQuota;
    response.set_header("RateLimit-Policy", policy);
    response.set_header("RateLimit", state);
    response.set_header("Retry-After", std::to_string(retryAfter.count()));
    writeProblem(service, response, proto::makeProblem(error));
}

/// @return true if the caller has used up the requests of this window
bool refusesRate(Service& service, httplib::Response& response, const Caller& caller) {
    const Charge charge = service.access->charge(caller);
    if (charge.granted) return false;
    const std::string quota = std::to_string(caller.quota.requests);
    const std::string window = std::to_string(caller.quota.window.count());
    core::Error error{ErrorCode::quotaExceeded,
                      "this key may make " + quota + " requests in " + window + " s"};
    error.limit = caller.quota.requests;
    refuseByQuota(service, response, "\"requests\";q=" + quota + ";w=" + window,
                  "\"requests\";r=0;t=" + std::to_string(charge.retryAfter.count()),
                  charge.retryAfter, error);
    return true;
}

/// @return true if the caller has as many jobs as it may
bool refusesJob(Service& service, httplib::Response& response, const Caller& caller) {
    if (caller.quota.jobs == 0) return false;
    auto place =
        service.access->reserveJob(caller, [&] { return service.pool.unfinished(caller.name); });
    if (place) {
        response.user_data.set(kUpload, std::move(place));
        return false;
    }
    const std::string quota = std::to_string(caller.quota.jobs);
    core::Error error{ErrorCode::quotaExceeded,
                      "this key may have " + quota + " jobs that have not ended"};
    error.limit = caller.quota.jobs;
    refuseByQuota(service, response, "\"jobs\";q=" + quota, "\"jobs\";r=0",
                  service.pool.retryAfter(), error);
    return true;
}

}  // namespace

Access::Access(std::shared_ptr<const KeyRing> ring, QuotaBook::Now now, WallClock wallNow)
    : wallNow_(std::move(wallNow)), quotas_(std::move(now)), ring_(std::move(ring)) {}

std::shared_ptr<const KeyRing> Access::ring() const {
    const std::lock_guard lock(mutex_);
    return ring_;
}

core::Result<void> Access::reload(const std::string& path) {
    auto loaded = KeyRing::load(path);
    if (!loaded) return fail(loaded.error());
    auto ring = std::make_shared<const KeyRing>(*std::move(loaded));
    quotas_.keepOnly(*ring);
    const std::lock_guard lock(mutex_);
    ring_ = std::move(ring);
    return {};
}

core::Result<Caller> Access::identify(const httplib::Request& request) const {
    const std::string presented = presentedKey(request);
    const std::shared_ptr<const KeyRing> keys = ring();
    const ApiKey* const key = presented.empty() ? nullptr : keys->find(presented);
    if (!key)
        return fail(ErrorCode::unauthorized,
                    "send one API key, as Authorization: Bearer KEY or as X-API-Key: KEY");
    if (!key->usable(wallNow_()))
        return fail(ErrorCode::forbidden,
                    key->disabled ? "this API key is switched off" : "this API key has expired");
    return Caller{key->name, key->quota};
}

std::shared_ptr<void> Access::reserveJob(const Caller& caller,
                                         const std::function<std::size_t()>& unfinished) {
    const std::lock_guard lock(mutex_);
    std::size_t& uploading = uploading_[caller.name];
    if (uploading + unfinished() >= caller.quota.jobs) return nullptr;
    ++uploading;
    return {static_cast<void*>(this), [this, name = caller.name](void*) {
                const std::lock_guard relock(mutex_);
                if (--uploading_[name] == 0) uploading_.erase(name);
            }};
}

bool needsKey(const std::string& path) { return path == "/v1" || path.starts_with("/v1/"); }

bool refusesCaller(Service& service, const httplib::Request& request, httplib::Response& response,
                   bool upload) {
    if (!service.access || !needsKey(request.path) || response.user_data.has(kCaller)) return false;
    const auto caller = service.access->identify(request);
    if (!caller) {
        if (caller.error().code == ErrorCode::unauthorized)
            response.set_header("WWW-Authenticate", "Bearer realm=\"rivage\"");
        writeProblem(service, response, proto::makeProblem(caller.error()));
        return true;
    }
    response.user_data.set(kCaller, *caller);
    return refusesRate(service, response, *caller) ||
           (upload && refusesJob(service, response, *caller));
}

const Caller& callerOf(const httplib::Response& response) {
    static const Caller kNobody;
    const auto* caller = response.user_data.get<Caller>(kCaller);
    return caller ? *caller : kNobody;
}

void releaseUpload(httplib::Response& response) { response.user_data.erase(kUpload); }

}  // namespace rivage::server
