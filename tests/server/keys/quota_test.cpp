#include "server/keys/quota.h"

#include <doctest/doctest.h>

#include <atomic>
#include <thread>
#include <vector>

using namespace rivage::server;
using namespace std::chrono_literals;

namespace {

struct FakeClock {
    std::chrono::steady_clock::time_point now = {};
    QuotaBook::Now reader() {
        return [this] { return now; };
    }
};

}  // namespace

TEST_SUITE_BEGIN("server/keys");

TEST_CASE("QuotaBook: a window's requests at once, then one for each part of the window") {
    FakeClock clock;
    QuotaBook book(clock.reader());
    const QuotaLimits limits{.requests = 3, .window = 60s};
    for (int i = 0; i < 3; ++i) CHECK(book.take("a", limits).granted);
    const Charge refused = book.take("a", limits);
    CHECK_FALSE(refused.granted);
    CHECK(refused.retryAfter == 20s);
    CHECK(book.take("b", limits).granted);
    clock.now += 19s;
    CHECK(book.take("a", limits).retryAfter == 1s);
    clock.now += 1s;
    CHECK(book.take("a", limits).granted);
    CHECK_FALSE(book.take("a", limits).granted);
    clock.now += 1h;
    for (int i = 0; i < 3; ++i) CHECK(book.take("a", limits).granted);
    CHECK_FALSE(book.take("a", limits).granted);
}

TEST_CASE("QuotaBook: no limit, no bucket; callers without a key are forgotten") {
    QuotaBook book;
    for (int i = 0; i < 1000; ++i) CHECK(book.take("free", {}).granted);
    CHECK(book.size() == 0);
    (void)book.take("a", {.requests = 1});
    (void)book.take("b", {.requests = 1});
    CHECK(book.size() == 2);
    book.keepOnly(KeyRing::parse("b sha256:" + std::string(64, '0')).value());
    CHECK(book.size() == 1);
    CHECK_FALSE(book.take("b", {.requests = 1, .window = 1h}).granted);
}

TEST_CASE("QuotaBook: threads together get what the bucket holds") {
    FakeClock clock;
    QuotaBook book(clock.reader());
    std::atomic<int> granted{0};
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            for (int i = 0; i < 100; ++i)
                if (book.take("a", {.requests = 50, .window = 1h}).granted) ++granted;
        });
    for (std::thread& thread : threads) thread.join();
    CHECK(granted == 50);
}

TEST_SUITE_END();
