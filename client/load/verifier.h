#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace rivage::client::load {

/// An answer that was drawn to be looked at.
struct VerifySample {
    int entry = 0;       ///< answers of one entry must be the same bytes
    bool same = false;   ///< whether that is asked for
    std::string type;    ///< Content-Type
    std::string digest;  ///< Content-Digest or Repr-Digest; empty: none was sent
    std::string body;
};

/// Whether bytes are a GLB: header, lengths, and a first chunk whose JSON can be parsed.
[[nodiscard]] bool isGlb(std::string_view bytes);

/// The sha-256 of bytes as a digest field has it, "sha-256=:BASE64:".
[[nodiscard]] std::string digestOf(std::string_view bytes);

/// What is wrong with an answer: "digest-mismatch" or "invalid-glb"; empty if nothing is.
[[nodiscard]] std::string faultOf(const VerifySample& sample);

/// Looks at answers in a thread of its own, so that the generator is not kept from sending.
class Verifier {
public:
    Verifier();
    ~Verifier();
    Verifier(const Verifier&) = delete;
    Verifier& operator=(const Verifier&) = delete;

    /// Hands an answer over; it is dropped if too many wait already.
    void look(VerifySample sample);
    /// Waits until everything that was handed over has been looked at.
    void finish();

    /// After `finish`.
    [[nodiscard]] std::uint64_t verified() const { return verified_; }
    [[nodiscard]] std::uint64_t skipped() const { return skipped_; }
    /// How many were wrong, by class; "different-result" if not the same as an earlier answer.
    [[nodiscard]] const std::map<std::string, std::uint64_t>& faults() const { return faults_; }

private:
    void work();
    void check(const VerifySample& sample);

    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<VerifySample> waiting_;
    bool stopping_ = false;
    std::uint64_t verified_ = 0;
    std::uint64_t skipped_ = 0;
    std::map<std::string, std::uint64_t> faults_;
    std::map<int, std::string> first_;  ///< digests, by entry
    std::thread thread_;
};

}  // namespace rivage::client::load
