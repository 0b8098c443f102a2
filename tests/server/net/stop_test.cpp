#include <doctest/doctest.h>

#include <vector>

#include "tests/server/net/net_server.h"

using namespace rivage;
using namespace rivage::test;
using namespace std::chrono_literals;
using server::NetLimits;
using server::Phase;

TEST_SUITE_BEGIN("server/net");

TEST_CASE("stop: what is under way is answered, idle connections are closed, nothing else begins") {
    NetServer server;
    RawClient idle(server.address);
    idle.send(get("/quick"));
    CHECK(statusOf(idle.readAnswer()) == 200);
    RawClient slow(server.address);
    slow.send(get("/slow"));
    RawClient reader(server.address);
    reader.send(get("/lent"));
    REQUIRE(server.waitFor(Phase::stream, 1));
    REQUIRE(eventually([&] { return server.running == 1; }));

    std::thread stopper([&] { server.front->stop(); });
    CHECK(idle.closedWithin(2s));
    RawClient late(server.address);
    late.send(get("/quick"));
    CHECK(late.readAnswer(300ms).empty());
    server.open = true;
    const std::string answer = slow.readAnswer();
    CHECK(answer.ends_with("slow"));
    CHECK(answer.find("Connection: close") != std::string::npos);
    CHECK(reader.readAnswer(20s).size() > server.big->size());
    slow.close();
    reader.close();
    stopper.join();
}

TEST_CASE("stop: a request that was on its way on an idle connection is answered, as the last") {
    NetLimits limits;
    limits.farewell = 1000ms;
    NetServer server(limits);
    RawClient client(server.address);
    client.send(get("/quick"));
    CHECK(statusOf(client.readAnswer()) == 200);
    REQUIRE(server.waitFor(Phase::idle, 1));
    std::thread stopper([&] { server.front->stop(); });
    std::this_thread::sleep_for(200ms);
    client.send(get("/quick"));
    const std::string answer = client.readAnswer();
    CHECK(statusOf(answer) == 200);
    CHECK(answer.find("Connection: close") != std::string::npos);
    client.close();
    stopper.join();
}

TEST_CASE("stop: a handler that does not end and a reader that does not read are broken off") {
    NetLimits limits;
    limits.stopTimeout = 300ms;
    NetServer server(limits);
    RawClient watcher(server.address);
    watcher.send(get("/watch"));
    RawClient reader(server.address, 4096);
    reader.send(get("/lent"));
    RawClient half(server.address);
    half.send("GET /");
    REQUIRE(eventually([&] { return server.running == 1; }));
    REQUIRE(server.waitFor(Phase::stream, 1));
    const auto began = std::chrono::steady_clock::now();
    server.front->stop();
    CHECK(std::chrono::steady_clock::now() - began < 2s);
    CHECK(server.gone == 1);
}

// Clients ask without a pause while a second server on the same socket takes over from the first.
TEST_CASE("stop: a server that shares the listener takes over, and no request is lost") {
    auto listener = server::listenOn({"127.0.0.1", 0, ""}).value();
    const server::Address address = listener.address;
    auto copy = server::share(listener).value();
    auto first = std::make_unique<NetServer>(NetLimits{}, std::move(listener));
    std::atomic<bool> ended{false};
    std::atomic<int> answered{0};
    std::atomic<int> lost{0};
    std::vector<std::thread> clients;
    for (int i = 0; i < 4; ++i)
        clients.emplace_back([&] {
            auto client = std::make_unique<RawClient>(address);
            while (!ended) {
                client->send(get("/quick"));
                const std::string answer = client->readAnswer();
                ++(statusOf(answer) == 200 ? answered : lost);
                if (answer.find("Connection: close") != std::string::npos || answer.empty())
                    client = std::make_unique<RawClient>(address);
            }
        });
    REQUIRE(eventually([&] { return answered > 200; }));
    first->front->stop();
    const int before = answered;
    std::this_thread::sleep_for(50ms);  // nobody accepts, nobody is refused
    const NetServer second(NetLimits{}, std::move(copy));
    CHECK(eventually([&] { return answered > before + 200; }));
    ended = true;
    for (std::thread& client : clients) client.join();
    CHECK(lost == 0);
}

TEST_SUITE_END();
