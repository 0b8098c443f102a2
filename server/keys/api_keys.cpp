#include "server/keys/api_keys.h"

#include <openssl/crypto.h>
#include <openssl/sha.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <span>

#include "server/jobs/digest.h"

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

constexpr std::size_t kMaxFileBytes = 4 << 20;
constexpr std::size_t kMaxKeys = 10000;
constexpr std::size_t kLeastKeyLength = 16;

/// Takes the next word off a line; a word that begins with '#' ends it.
std::string_view takeWord(std::string_view& line) {
    constexpr std::string_view kSpace = " \t\r";
    const std::size_t begin = std::min(line.find_first_not_of(kSpace), line.size());
    line.remove_prefix(begin);
    const std::string_view word = line.substr(0, line.find_first_of(kSpace));
    line.remove_prefix(word.size());
    if (!word.starts_with('#')) return word;
    line = {};
    return {};
}

template <typename T>
bool readWhole(std::string_view text, T& value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size();
}

bool isName(std::string_view name) {
    return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '.' || c == '_' || c == '-';
    });
}

bool readHash(std::string_view text, std::array<unsigned char, 32>& hash) {
    constexpr std::string_view kPrefix = "sha256:";
    if (!text.starts_with(kPrefix) || text.size() != kPrefix.size() + 2 * hash.size()) return false;
    text.remove_prefix(kPrefix.size());
    for (std::size_t i = 0; i < hash.size(); ++i) {
        const char* const byte = text.data() + 2 * i;
        const auto [end, error] = std::from_chars(byte, byte + 2, hash[i], 16);
        if (error != std::errc() || end != byte + 2) return false;
    }
    return true;
}

/// "60/m" -> 60 requests in 60 s.
bool readRate(std::string_view text, QuotaLimits& quota) {
    const std::size_t slash = text.find('/');
    if (slash == std::string_view::npos || text.size() != slash + 2) return false;
    switch (text.back()) {
        case 's': quota.window = std::chrono::seconds(1); break;
        case 'm': quota.window = std::chrono::minutes(1); break;
        case 'h': quota.window = std::chrono::hours(1); break;
        default: return false;
    }
    return readWhole(text.substr(0, slash), quota.requests) && quota.requests > 0;
}

/// "2027-01-31" -> the end of that day.
bool readDate(std::string_view text, std::optional<proto::WallTime>& time) {
    int year = 0;
    unsigned month = 0;
    unsigned day = 0;
    if (text.size() != 10 || text[4] != '-' || text[7] != '-' ||
        !readWhole(text.substr(0, 4), year) || !readWhole(text.substr(5, 2), month) ||
        !readWhole(text.substr(8, 2), day))
        return false;
    const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(month),
                                           std::chrono::day(day)};
    if (!date.ok()) return false;
    time = std::chrono::sys_days(date) + std::chrono::days(1);
    return true;
}

/// @return what is wrong with one word after the hash; empty if nothing is
std::string readAttribute(std::string_view word, ApiKey& key) {
    if (word == "disabled") {
        key.disabled = true;
        return {};
    }
    const std::size_t equals = std::min(word.find('='), word.size());
    const std::string name(word.substr(0, equals));
    const std::string_view value = word.substr(std::min(equals + 1, word.size()));
    if (name == "rate")
        return readRate(value, key.quota) ? "" : "rate must be as in rate=60/m, with s, m or h";
    if (name == "jobs")
        return readWhole(value, key.quota.jobs) && key.quota.jobs > 0
                   ? ""
                   : "jobs must be a number from 1, as in jobs=4";
    if (name == "expires")
        return readDate(value, key.expires) ? ""
                                            : "expires must be a day, as in expires=2027-01-31";
    return "there is no attribute " + proto::inQuotes(name);
}

/// @return what is wrong with a line that is not empty; empty if nothing is
std::string readLine(std::string_view line, ApiKey& key) {
    key.name = std::string(takeWord(line));
    if (!isName(key.name)) return "a name has 1 to 64 letters, digits, '.', '_' or '-'";
    if (!readHash(takeWord(line), key.hash)) return "sha256: and 64 hexadecimal digits must follow";
    for (std::string_view word = takeWord(line); !word.empty(); word = takeWord(line))
        if (std::string wrong = readAttribute(word, key); !wrong.empty()) return wrong;
    return {};
}

std::string duplicate(const std::vector<ApiKey>& keys, const ApiKey& key) {
    for (const ApiKey& other : keys) {
        if (other.name == key.name) return "the name " + key.name + " is there twice";
        if (other.hash == key.hash) return "the key is that of " + other.name;
    }
    return keys.size() < kMaxKeys ? std::string() : "there are too many keys";
}

}  // namespace

core::Result<KeyRing> KeyRing::parse(std::string_view text) {
    KeyRing ring;
    for (std::size_t number = 1; !text.empty(); ++number) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        std::string_view rest = line;
        if (takeWord(rest).empty()) continue;

        ApiKey key;
        std::string wrong = readLine(line, key);
        if (wrong.empty()) wrong = duplicate(ring.keys_, key);
        if (!wrong.empty())
            return fail(ErrorCode::invalidOption, "line " + std::to_string(number) + ": " + wrong);
        ring.keys_.push_back(std::move(key));
    }
    return ring;
}

core::Result<KeyRing> KeyRing::load(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::string text(kMaxFileBytes + 1, '\0');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (file.bad() || !file.is_open() || (file.fail() && !file.eof()))
        return fail(ErrorCode::invalidOption, "cannot read " + path);
    text.resize(static_cast<std::size_t>(file.gcount()));
    if (text.size() > kMaxFileBytes) return fail(ErrorCode::invalidOption, path + " is too long");
    auto ring = parse(text);
    if (!ring) return fail(ErrorCode::invalidOption, path + ", " + ring.error().message);
    return ring;
}

const ApiKey* KeyRing::find(std::string_view presented) const {
    std::array<unsigned char, SHA256_DIGEST_LENGTH> hash{};
    ::SHA256(reinterpret_cast<const unsigned char*>(presented.data()), presented.size(),
             hash.data());
    const ApiKey* found = nullptr;
    for (const ApiKey& key : keys_) {
        const bool same = ::CRYPTO_memcmp(key.hash.data(), hash.data(), hash.size()) == 0;
        found = same ? &key : found;
    }
    return found;
}

core::Result<std::string> keyLine(const std::string& name, std::string_view key) {
    if (!isName(name)) return fail(ErrorCode::invalidOption, "the name of the key is none");
    const bool visible =
        std::all_of(key.begin(), key.end(), [](char c) { return c > ' ' && c < 0x7f; });
    if (key.size() < kLeastKeyLength || !visible)
        return fail(ErrorCode::invalidOption,
                    "a key has at least 16 characters, all of them visible ASCII");
    return name + " sha256:" + sha256(std::as_bytes(std::span(key.data(), key.size()))).hex;
}

}  // namespace rivage::server
