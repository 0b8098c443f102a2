#include "server/jobs/blob_store.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <thread>
#include <vector>

using namespace rivage;
using namespace rivage::server;

namespace {

BlobPtr put(MemoryBlobStore& store, std::size_t size, int value) {
    const auto blob = store.put(std::vector(size, static_cast<std::byte>(value)));
    REQUIRE(blob);
    return *blob;
}

}  // namespace

TEST_CASE("memory blobs: the same bytes are kept once, as long as somebody holds them") {
    MemoryBlobStore store;
    BlobPtr first = put(store, 1000, 1);
    CHECK(put(store, 1000, 1) == first);
    CHECK(put(store, 1000, 1) == first);
    CHECK(put(store, 1000, 2) != first);
    CHECK(put(store, 999, 1) != first);

    const std::weak_ptr<const Blob> gone = first;
    first.reset();
    CHECK(gone.expired());
    const BlobPtr again = put(store, 1000, 1);
    CHECK(std::ranges::equal(again->bytes(), std::vector(1000, std::byte{1})));
}

TEST_CASE("memory blobs: one outlives its store") {
    BlobPtr blob;
    {
        MemoryBlobStore store;
        blob = put(store, 10, 3);
    }
    CHECK(blob->bytes().size() == 10);
    blob.reset();
}

TEST_CASE("memory blobs: many threads put and let go of the same bytes") {
    MemoryBlobStore store;
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i)
        threads.emplace_back([&] {
            for (int n = 0; n < 2000; ++n) {
                const auto blob = store.put(std::vector(16, static_cast<std::byte>(n % 3)));
                CHECK(((*blob)->bytes().front() == static_cast<std::byte>(n % 3)));
            }
        });
    for (auto& thread : threads) thread.join();
    const BlobPtr one = put(store, 16, 0);
    CHECK(put(store, 16, 0) == one);
}
