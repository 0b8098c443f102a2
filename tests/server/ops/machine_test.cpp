#include "server/ops/machine.h"

#include <doctest/doctest.h>

#include <thread>

TEST_SUITE_BEGIN("server/ops");

TEST_CASE("machine: what may be used lies within what is there") {
    CHECK(rivage::server::usableProcessors() >= 1);
    CHECK(rivage::server::usableProcessors() <= std::thread::hardware_concurrency());
    CHECK(rivage::server::usableMemory() >= 16U << 20);
}

TEST_SUITE_END();
