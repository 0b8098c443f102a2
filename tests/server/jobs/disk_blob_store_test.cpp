#include "server/jobs/disk_blob_store.h"

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <random>
#include <string>
#include <thread>

#include "tests/support/temporary_folder.h"

using namespace rivage;
using namespace rivage::server;
using core::ErrorCode;

namespace {

std::unique_ptr<BlobStore> openStore(const std::string& folder) {
    auto store = openDiskBlobStore(folder);
    REQUIRE_MESSAGE(store, (store ? "" : store.error().message));
    return *std::move(store);
}

/// Bytes that do not compress and differ by seed.
std::vector<std::byte> randomBytes(std::size_t size, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::byte> bytes(size);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
    return bytes;
}

std::string pathOf(const std::string& folder, const Digest& digest) {
    return folder + "/blobs/" + digest.hex.substr(0, 2) + "/" + digest.hex;
}

std::size_t filesBelow(const std::string& folder) {
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        files += entry.is_regular_file() ? 1 : 0;
    return files;
}

bool none(const std::string&) { return false; }

/// Sizes around the one from which blobs are mapped, and an empty one.
constexpr std::size_t kSizes[] = {0, 1, (64 << 10) - 1, 64 << 10, (64 << 10) + 1, 3 << 20};

}  // namespace

TEST_SUITE_BEGIN("server/jobs");

TEST_CASE("disk blobs: bytes come back, now and from the next store") {
    const test::TemporaryFolder folder;
    for (const std::size_t size : kSizes) {
        CAPTURE(size);
        const auto bytes = randomBytes(size, 1);
        const Digest digest = sha256(bytes);
        {
            const auto store = openStore(folder.path());
            const auto put = store->put(bytes);
            REQUIRE(put);
            CHECK((*put)->durable());
            CHECK((*put)->digest().hex == digest.hex);
            CHECK((*put)->digest().base64 == digest.base64);
            CHECK(std::ranges::equal((*put)->bytes(), bytes));
        }
        struct stat status {};
        REQUIRE(::stat(pathOf(folder.path(), digest).c_str(), &status) == 0);
        CHECK((status.st_mode & 0777) == 0600);
        const auto opened = openStore(folder.path())->open({digest.hex, ""});
        REQUIRE(opened);
        CHECK((*opened)->digest().base64 == digest.base64);
        CHECK(std::ranges::equal((*opened)->bytes(), bytes));
    }
    CHECK(filesBelow(folder.path()) == std::size(kSizes));
}

TEST_CASE("disk blobs: the same bytes are one object and one file") {
    const test::TemporaryFolder folder;
    const auto store = openStore(folder.path());
    const auto bytes = randomBytes(100'000, 1);
    const BlobPtr first = store->put(bytes).value();
    CHECK(store->put(bytes).value() == first);
    CHECK(store->open(first->digest()).value() == first);
    CHECK(filesBelow(folder.path()) == 1);
}

TEST_CASE("disk blobs: what is not there, and what is no digest, is not found") {
    const test::TemporaryFolder folder;
    const auto store = openStore(folder.path());
    for (const std::string& hex : {sha256({}).hex, std::string("../../../etc/passwd"),
                                   std::string(), std::string(64, 'G'), std::string(64, '/')}) {
        CAPTURE(hex);
        const auto opened = store->open({hex, ""});
        REQUIRE_FALSE(opened);
        CHECK(opened.error().code == ErrorCode::notFound);
    }
}

TEST_CASE("disk blobs: a damaged file is not handed out, and is mended by putting its bytes") {
    const test::TemporaryFolder folder;
    for (const std::size_t size : {std::size_t{1000}, std::size_t{100'000}}) {
        CAPTURE(size);
        const auto bytes = randomBytes(size, 1);
        const Digest digest = openStore(folder.path())->put(bytes).value()->digest();
        const std::string path = pathOf(folder.path(), digest);
        const std::string whole = test::readFile(path);
        std::string flipped = whole;
        flipped[size / 2] = static_cast<char>(flipped[size / 2] ^ 1);
        for (const std::string& damage : {flipped, whole.substr(1), whole + "x", std::string()}) {
            test::writeFile(path, damage);
            const auto store = openStore(folder.path());
            const auto opened = store->open(digest);
            REQUIRE_FALSE(opened);
            CHECK(opened.error().code == ErrorCode::internal);
            CHECK(opened.error().message.find("damaged") != std::string::npos);
            CHECK(opened.error().message.find(folder.path()) == std::string::npos);
            REQUIRE(store->put(bytes));
            CHECK(test::readFile(path) == whole);
        }
    }
}

TEST_CASE("disk blobs: collect leaves what is held or needed, and nothing else") {
    const test::TemporaryFolder folder;
    const auto store = openStore(folder.path());
    const BlobPtr held = store->put(randomBytes(100'000, 1)).value();
    const Digest needed = store->put(randomBytes(100'000, 2)).value()->digest();
    const Digest other = store->put(randomBytes(100'000, 3)).value()->digest();
    store->collect([&](const std::string& hex) { return hex == needed.hex; });
    CHECK(filesBelow(folder.path()) == 2);
    CHECK(store->open(needed));
    CHECK_FALSE(store->open(other));

    store->collect(none);  // `needed` was just opened, but nobody holds it
    CHECK(filesBelow(folder.path()) == 1);
    CHECK(held->bytes().size() == 100'000);
    CHECK(store->put(randomBytes(100'000, 3)));
    test::writeFile(folder.path() + "/blobs/README", "not ours");
    store->collect(none);
    CHECK(filesBelow(folder.path()) == 2);
}

TEST_CASE("disk blobs: leftovers of a crash are removed at the start") {
    const test::TemporaryFolder folder;
    static_cast<void>(openStore(folder.path()));
    test::writeFile(folder.path() + "/tmp/half", "written");
    const auto store = openStore(folder.path());
    CHECK(filesBelow(folder.path()) == 0);
    REQUIRE(store->put(randomBytes(10, 1)));
    CHECK(filesBelow(folder.path() + "/tmp") == 0);
}

// What threads put and hold can be opened by its digest whatever `collect` does meanwhile.
TEST_CASE("property: collect never takes a blob from under those who put it") {
    const test::TemporaryFolder folder;
    const auto store = openStore(folder.path());
    std::atomic<bool> done{false};
    std::thread collector([&] {
        while (!done) store->collect(none);
    });
    std::vector<std::thread> threads;
    for (unsigned t = 0; t < 3; ++t)
        threads.emplace_back([&, t] {
            for (unsigned i = 0; i < 60; ++i) {
                const auto blob = store->put(randomBytes(70'000, (i + t) % 4));
                CHECK(blob);
                if (!blob) return;
                CHECK(std::filesystem::exists(pathOf(folder.path(), (*blob)->digest())));
                CHECK(std::ranges::equal((*blob)->bytes(), randomBytes(70'000, (i + t) % 4)));
            }
        });
    for (std::thread& thread : threads) thread.join();
    done = true;
    collector.join();
    store->collect(none);
    CHECK(filesBelow(folder.path()) == 0);
}

// A record may come to need a blob between the question and the removal; then it was held since.
TEST_CASE("disk blobs: a blob that was used while collect asked stays") {
    const test::TemporaryFolder folder;
    const auto store = openStore(folder.path());
    const auto bytes = randomBytes(10, 1);
    const Digest digest = store->put(bytes).value()->digest();
    store->collect([&](const std::string&) {
        CHECK(store->put(bytes));  // and dropped at once
        return false;
    });
    CHECK(store->open(digest));
}

TEST_CASE("disk blobs: a full disk is named, and leaves no part of a blob") {
    const test::SmallDisk disk(1 << 20);
    if (!disk.mounted()) {
        MESSAGE("skipped: only root can mount a small disk");
        return;
    }
    const auto store = openStore(disk.path());
    const BlobPtr kept = store->put(randomBytes(300'000, 1)).value();
    const auto refused = store->put(randomBytes(900'000, 2));
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ErrorCode::storageFull);
    CHECK(refused.error().setting == "--state-dir");
    CHECK(filesBelow(disk.path()) == 1);
    CHECK(std::ranges::equal(kept->bytes(), randomBytes(300'000, 1)));
    CHECK(store->put(randomBytes(300'000, 3)));
}

TEST_SUITE_END();
