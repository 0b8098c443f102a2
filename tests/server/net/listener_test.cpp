#include "server/net/listener.h"

#include <doctest/doctest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>

#include "tests/server/net/raw_client.h"

using namespace rivage;
using namespace rivage::server;

TEST_SUITE_BEGIN("server/net");

TEST_CASE("listenOn: any free port, and the reasons why an address cannot be bound") {
    const auto listener = listenOn({"127.0.0.1", 0, ""});
    REQUIRE(listener);
    CHECK(listener->address.port > 0);
    const auto again = listenOn(listener->address);
    REQUIRE_FALSE(again);
    CHECK(again.error().code == core::ErrorCode::busy);
    for (const char* host : {"no such host.invalid", "203.0.113.7"}) {
        const auto nowhere = listenOn({host, 0, ""});
        REQUIRE_FALSE(nowhere);
        CHECK(nowhere.error().code == core::ErrorCode::invalidOption);
    }
}

TEST_CASE("Listener: a shared one outlives its first owner; only `remove` takes the file away") {
    const std::string path =
        (std::filesystem::temp_directory_path() / ("rivage-listener-" + std::to_string(::getpid())))
            .string();
    auto first = listenOn({"", 0, path});
    REQUIRE(first);
    auto second = share(*first);
    REQUIRE(second);
    first->fd.reset();
    CHECK(std::filesystem::exists(path));
    const test::RawClient client(second->address);
    CHECK(client.connected());
    const Fd accepted(::accept(second->fd.get(), nullptr, nullptr));
    CHECK(accepted);
    second->remove();
    CHECK_FALSE(std::filesystem::exists(path));
}

TEST_SUITE_END();
