#include "server/jobs/crash_board.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <vector>

#include "server/jobs/file.h"

namespace rivage::server {
namespace {

using core::fail;

/// The last character is the version of the layout.
constexpr std::array<char, 8> kMagic{'R', 'I', 'V', 'C', 'R', 'S', 'H', '1'};
constexpr std::size_t kDigestBytes = 32;

enum SlotState : std::uint32_t { kFree, kRunning, kAccused };

/// `state` is written last when a run begins and first when it ends, so that the digest is whole
/// whenever `state` says that there is one.
struct Slot {
    std::atomic<std::uint32_t> state;
    unsigned char digest[kDigestBytes];
};

/// `crashes` is 0 while the rest is being written.
struct Input {
    std::atomic<std::uint32_t> crashes;
    unsigned char digest[kDigestBytes];
    std::int64_t lastCrash;  ///< seconds since 1970
};

static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

std::array<unsigned char, kDigestBytes> bytesOf(const std::string& hex) {
    assert(hex.size() == 2 * kDigestBytes);
    const auto digit = [&](std::size_t i) {
        const char c = i < hex.size() ? hex[i] : '0';
        return static_cast<unsigned>(c <= '9' ? c - '0' : c - 'a' + 10) & 15U;
    };
    std::array<unsigned char, kDigestBytes> bytes{};
    for (std::size_t i = 0; i < kDigestBytes; ++i)
        bytes[i] = static_cast<unsigned char>(digit(2 * i) << 4U | digit(2 * i + 1));
    return bytes;
}

std::int64_t now() {
    const auto time = std::chrono::system_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::seconds>(time).count();
}

}  // namespace

struct CrashBoard::Memory {
    std::array<char, 8> magic;
    Slot slots[kSlots];
    Input inputs[kInputs];

    Input* find(const unsigned char* digest) {
        Input* const found = std::find_if(inputs, inputs + kInputs, [&](const Input& input) {
            return input.crashes != 0 && std::memcmp(input.digest, digest, kDigestBytes) == 0;
        });
        return found == inputs + kInputs ? nullptr : found;
    }
    /// A free place, or the one whose last crash is longest ago.
    Input& place() {
        return *std::min_element(inputs, inputs + kInputs, [](const Input& a, const Input& b) {
            const auto age = [](const Input& input) {
                return input.crashes == 0 ? INT64_MIN : input.lastCrash;
            };
            return age(a) < age(b);
        });
    }
};

namespace {

/// Makes sure that the file has all its blocks: a page without one would be a SIGBUS on a full disk.
core::Result<Fd> openBoard(const std::string& path, std::size_t size) {
    Fd file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
    if (!file) return fail(diskError("open its crash board", errno));
    struct stat status {};
    const bool ours =
        ::fstat(file.get(), &status) == 0 && status.st_size == static_cast<off_t>(size);
    if (!ours && ::ftruncate(file.get(), 0) != 0)
        return fail(diskError("begin its crash board", errno));
    const int code = ::posix_fallocate(file.get(), 0, static_cast<off_t>(size));
    if (code != 0) return fail(diskError("make its crash board", code));
    return file;
}

}  // namespace

core::Result<std::unique_ptr<CrashBoard>> CrashBoard::open(const std::string& path,
                                                           std::chrono::seconds quarantine) {
    Fd file;
    if (!path.empty()) {
        auto opened = openBoard(path, sizeof(Memory));
        if (!opened) return fail(opened.error());
        file = *std::move(opened);
    }
    const int flags = MAP_SHARED | (path.empty() ? MAP_ANONYMOUS : 0);
    void* const map = ::mmap(nullptr, sizeof(Memory), PROT_READ | PROT_WRITE, flags, file.get(), 0);
    if (map == MAP_FAILED) return fail(diskError("map its crash board", errno));
    auto* const memory = static_cast<Memory*>(map);
    if (memory->magic != kMagic) {
        std::memset(map, 0, sizeof(Memory));
        memory->magic = kMagic;
    }
    return std::unique_ptr<CrashBoard>(new CrashBoard(memory, quarantine));
}

CrashBoard::~CrashBoard() { ::munmap(memory_, sizeof(Memory)); }

std::size_t CrashBoard::recover() {
    const std::lock_guard lock(mutex_);
    const bool accused = std::ranges::any_of(
        memory_->slots, [](const Slot& slot) { return slot.state == kAccused; });
    std::vector<std::array<unsigned char, kDigestBytes>> counted;
    for (Slot& slot : memory_->slots) {
        // Free first: a crash right here may lose a count, but never makes two of one.
        const std::uint32_t state = slot.state.exchange(kFree);
        if (state != kAccused && (accused || state == kFree)) continue;
        std::array<unsigned char, kDigestBytes> digest{};
        std::ranges::copy(slot.digest, digest.begin());
        if (std::ranges::find(counted, digest) != counted.end()) continue;
        counted.push_back(digest);
        count(digest.data());
    }
    return counted.size();
}

void CrashBoard::count(const unsigned char* digest) {
    Input* input = memory_->find(digest);
    const std::uint32_t before =
        input && now() - input->lastCrash < quarantine_.count() ? input->crashes.load() : 0;
    if (!input) input = &memory_->place();
    input->crashes = 0;
    std::memcpy(input->digest, digest, kDigestBytes);
    input->lastCrash = now();
    input->crashes = before + 1;
}

int CrashBoard::crashes(const std::string& hex) const {
    const std::lock_guard lock(mutex_);
    const Input* const input = memory_->find(bytesOf(hex).data());
    const bool known = input && now() - input->lastCrash < quarantine_.count();
    return known ? static_cast<int>(input->crashes) : 0;
}

void CrashBoard::begin(std::size_t slot, const std::string& hex) {
    assert(slot < kSlots);
    const auto digest = bytesOf(hex);
    Slot& begun = memory_->slots[slot];
    // Free first: a crash right here would find half of each digest in a slot that was not ended.
    begun.state.exchange(kFree);
    std::ranges::copy(digest, begun.digest);
    begun.state.store(kRunning, std::memory_order_release);
}

void CrashBoard::accuse(std::size_t slot) noexcept {
    std::uint32_t running = kRunning;
    if (slot < kSlots) memory_->slots[slot].state.compare_exchange_strong(running, kAccused);
}

void CrashBoard::end(std::size_t slot) {
    assert(slot < kSlots);
    Slot& ended = memory_->slots[slot];
    ended.state = kFree;
    const std::lock_guard lock(mutex_);
    if (Input* const input = memory_->find(ended.digest)) input->crashes = 0;
}

void CrashBoard::clear() noexcept {
    for (Slot& slot : memory_->slots) slot.state = kFree;
}

}  // namespace rivage::server
