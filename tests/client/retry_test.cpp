#include "client/retry.h"

#include <doctest/doctest.h>

namespace rivage::client {

using namespace std::chrono_literals;

TEST_SUITE_BEGIN("client");

TEST_CASE("retry: Retry-After as seconds and as a date") {
    const auto now = std::chrono::system_clock::from_time_t(784'111'777);  // 08:49:37
    CHECK(retryAfter("", now) == 0ms);
    CHECK(retryAfter("7", now) == 7s);
    CHECK(retryAfter("Sun, 06 Nov 1994 08:49:47 GMT", now) == 10s);
    CHECK(retryAfter("Sun, 06 Nov 1994 08:49:30 GMT", now) == 0ms);
    for (const char* text : {"-1", "7s", "soon", "Sun, 06 Nov 1994", "99999999999999999999"})
        CHECK(retryAfter(text, now) == 0ms);
}

TEST_CASE("property: jitter is below the doubled base and the cap, and uses all of the room") {
    constexpr RetryPolicy kPolicy{.base = 100ms, .cap = 1000ms};
    std::mt19937_64 random(1);
    for (int n = 1; n < 40; ++n) {
        const auto room = n < 4 ? 100ms * (1 << n) : 1000ms;
        auto least = room;
        auto most = 0ms;
        for (int i = 0; i < 300; ++i) {
            const auto pause = jitter(kPolicy, n, random);
            least = std::min(least, pause);
            most = std::max(most, pause);
        }
        CAPTURE(n);
        CHECK(least >= 0ms);
        CHECK(least < room / 10);
        CHECK(most <= room);
        CHECK(most > room * 9 / 10);
    }
}

TEST_SUITE_END();

}  // namespace rivage::client
