#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "core/base/result.h"
#include "server/jobs/job.h"

namespace rivage::server {

/// Reads an Idempotency-Key: a structured-field string, or a bare token, of 1 to 255 characters.
/// @errors malformedRequest
core::Result<std::string> readIdempotencyKey(const std::string& header);

/// Which request made which job, by the idempotency keys of clients: a request that comes again
/// finds its job. A key is remembered as long as its job is. Safe to use from several threads.
/// @source draft-ietf-httpapi-idempotency-key-header
class IdempotencyKeys {
public:
    /// The right to use a key, from the headers of a request to its job; given back if there is
    /// none in the end.
    class Claim {
    public:
        Claim() = default;
        Claim(Claim&& other) noexcept
            : keys_(std::exchange(other.keys_, nullptr)), name_(std::move(other.name_)) {}
        Claim& operator=(Claim&& other) noexcept {
            std::swap(keys_, other.keys_);
            std::swap(name_, other.name_);
            return *this;
        }
        ~Claim() {
            if (keys_) keys_->drop(name_);
        }
        /// The request has its job.
        void settle(const std::shared_ptr<Job>& job) {
            if (keys_) std::exchange(keys_, nullptr)->set(name_, job);
        }

    private:
        friend class IdempotencyKeys;
        using Name = std::pair<std::string, std::string>;  ///< owner and key
        Claim(IdempotencyKeys* keys, Name name) : keys_(keys), name_(std::move(name)) {}
        IdempotencyKeys* keys_ = nullptr;
        Name name_;
    };

    /// What there is about a key: its job, or else the right to use it.
    struct Lookup {
        std::shared_ptr<Job> job = {};
        Claim claim = {};
    };

    /// @errors keyInProgress while another request holds the claim
    core::Result<Lookup> claim(const std::string& owner, const std::string& key);
    /// A job of an earlier process, or one that was accepted.
    void remember(const std::shared_ptr<Job>& job);
    /// Forgets the keys whose jobs are gone.
    void sweep();

private:
    struct Entry {
        bool claimed = false;
        std::weak_ptr<Job> job = {};
    };
    void set(const Claim::Name& name, const std::shared_ptr<Job>& job);
    void drop(const Claim::Name& name);

    std::mutex mutex_;
    std::map<Claim::Name, Entry> entries_;
};

}  // namespace rivage::server
