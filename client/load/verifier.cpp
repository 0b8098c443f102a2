#include "client/load/verifier.h"

#include <openssl/evp.h>

#include <array>
#include <cstring>
#include <utility>

#include "client/load/taxonomy.h"

namespace rivage::client::load {
namespace {

constexpr std::size_t kMaxWaiting = 64;
constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::size_t kHeader = 12;
constexpr std::size_t kChunkHeader = 8;
constexpr std::size_t kMaxGlbJson = 16 << 20;

/// The u32 at an offset; GLB and this machine are both little-endian.
std::uint32_t numberAt(std::string_view bytes, std::size_t offset) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

/// The digest of a field with this algorithm in the form of `digestOf`; empty if it has none.
std::string sha256Member(const std::string& field) {
    const std::size_t begin = field.find("sha-256=:");
    if (begin == std::string::npos) return {};
    const std::size_t end = field.find(':', begin + 9);
    return end == std::string::npos ? field.substr(begin) : field.substr(begin, end + 1 - begin);
}

}  // namespace

bool isGlb(std::string_view bytes) {
    if (bytes.size() < kHeader + kChunkHeader || numberAt(bytes, 0) != kMagic ||
        numberAt(bytes, 4) != 2 || numberAt(bytes, 8) != bytes.size())
        return false;
    std::size_t at = kHeader;
    for (int chunk = 0; at < bytes.size(); ++chunk) {
        if (bytes.size() - at < kChunkHeader) return false;
        const std::size_t length = numberAt(bytes, at);
        if (length % 4 != 0 || length > bytes.size() - at - kChunkHeader) return false;
        if (chunk == 0) {
            const std::string_view text = bytes.substr(at + kChunkHeader, length);
            const proto::Json json = readAnswer(text, kMaxGlbJson);
            if (numberAt(bytes, at + 4) != kJsonChunk || !json.contains("asset")) return false;
        }
        at += kChunkHeader + length;
    }
    return true;
}

std::string digestOf(std::string_view bytes) {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned size = 0;
    EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr);
    std::array<unsigned char, 2 * EVP_MAX_MD_SIZE> text{};
    const int length = EVP_EncodeBlock(text.data(), digest.data(), static_cast<int>(size));
    return "sha-256=:" + std::string(text.begin(), text.begin() + length) + ":";
}

std::string faultOf(const VerifySample& sample) {
    const std::string announced = sha256Member(sample.digest);
    if (!announced.empty() && announced != digestOf(sample.body)) return "digest-mismatch";
    if (sample.type == "model/gltf-binary" && !isGlb(sample.body)) return "invalid-glb";
    return {};
}

Verifier::Verifier() : thread_([this] { work(); }) {}

Verifier::~Verifier() { finish(); }

void Verifier::look(VerifySample sample) {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() >= kMaxWaiting) {
        ++skipped_;
        return;
    }
    waiting_.push_back(std::move(sample));
    changed_.notify_one();
}

void Verifier::finish() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
        changed_.notify_one();
    }
    if (thread_.joinable()) thread_.join();
}

void Verifier::work() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
        if (waiting_.empty()) return;
        const std::vector<VerifySample> samples = std::exchange(waiting_, {});
        lock.unlock();
        for (const VerifySample& sample : samples) check(sample);
        lock.lock();
    }
}

/// Only the thread of the verifier counts, and only after its end is read what it counted.
void Verifier::check(const VerifySample& sample) {
    ++verified_;
    std::string fault = faultOf(sample);
    if (fault.empty() && sample.same) {
        const std::string digest = digestOf(sample.body);
        const auto [first, isNew] = first_.emplace(sample.entry, digest);
        if (!isNew && first->second != digest) fault = "different-result";
    }
    if (!fault.empty()) ++faults_[fault];
}

}  // namespace rivage::client::load
