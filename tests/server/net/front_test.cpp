#include "server/net/front.h"

#include <doctest/doctest.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <vector>

#include "tests/server/net/net_server.h"

using namespace rivage;
using namespace rivage::test;
using namespace std::chrono_literals;
using server::NetLimits;
using server::Phase;

namespace {

using Clients = std::vector<std::unique_ptr<RawClient>>;

std::string post(const std::string& path, const std::string& headers, const std::string& body) {
    return "POST " + path + " HTTP/1.1\r\nHost: x\r\n" + headers + "\r\n" + body;
}

std::string sized(const std::string& path, const std::string& body) {
    return post(path, "Content-Length: " + std::to_string(body.size()) + "\r\n", body);
}

}  // namespace

TEST_SUITE_BEGIN("server/net");

TEST_CASE("Front: pipelined requests are answered in their order, however they are cut") {
    const NetServer server;
    const std::string requests = get("/quick") + sized("/upload", "12345") + get("/nothing") +
                                 "\r\n" + sized("/upload", "") + get("/quick");
    for (const std::size_t cut : {requests.size(), std::size_t{7}, std::size_t{90}}) {
        CAPTURE(cut);
        RawClient client(server.address);
        for (std::size_t at = 0; at < requests.size(); at += cut) {
            client.send(requests.substr(at, cut));
            if (cut != requests.size()) std::this_thread::sleep_for(5ms);
        }
        CHECK(client.readAnswer().ends_with("\r\n\r\nquick"));
        CHECK(client.readAnswer().ends_with("\r\n\r\n5"));
        CHECK(statusOf(client.readAnswer()) == 404);
        CHECK(client.readAnswer().ends_with("\r\n\r\n0"));
        CHECK(client.readAnswer().ends_with("\r\n\r\nquick"));
    }
}

TEST_CASE("Front: 500 idle connections need no thread and stay usable") {
    NetLimits limits;
    limits.handlerIdle = 100ms;
    const NetServer server(limits);
    Clients clients;
    for (int i = 0; i < 500; ++i) {
        clients.push_back(std::make_unique<RawClient>(server.address));
        clients.back()->send(get("/quick"));
        REQUIRE(statusOf(clients.back()->readAnswer()) == 200);
    }
    CHECK(server.waitFor(Phase::idle, 500));
    CHECK(eventually([&] { return server.front->handlerThreads() == 0; }));
    for (const auto& client : clients) client->send(get("/quick"));
    for (const auto& client : clients) CHECK(statusOf(client->readAnswer()) == 200);
}

TEST_CASE("Front: an idle connection is closed after its time") {
    NetLimits limits;
    limits.idleTimeout = 100ms;
    const NetServer server(limits);
    RawClient client(server.address);
    client.send(get("/quick"));
    CHECK(client.readAnswer().find("Connection: close") == std::string::npos);
    CHECK(client.closedWithin(2s));
    CHECK(server.waitFor(Phase::closing, 1));
    client.close();
    CHECK(server.waitFor(Phase::closing, 0));
}

TEST_CASE("Front: connections over the cap get 503 and are closed; later there is room again") {
    NetLimits limits;
    limits.connections = 4;
    const NetServer server(limits);
    Clients clients;
    for (int i = 0; i < 4; ++i) clients.push_back(std::make_unique<RawClient>(server.address));
    REQUIRE(server.waitFor(Phase::header, 4));
    for (int i = 0; i < 3; ++i) {
        RawClient extra(server.address);
        extra.send(get("/quick"));
        const std::string answer = extra.readAnswer();
        CHECK(statusOf(answer) == 503);
        CHECK(answer.find("/problems/queue-full") != std::string::npos);
        CHECK(answer.find("Retry-After: 1\r\n") != std::string::npos);
        CHECK(answer.find("--connections") != std::string::npos);
        CHECK(extra.closedWithin(1s));
    }
    CHECK(server.refused == 3);
    clients[0]->close();
    REQUIRE(server.waitFor(Phase::header, 3));
    CHECK(quickMilliseconds(server.address) < 1000);
}

TEST_CASE("Front: at the cap of handlers requests wait in order, and get 503 if it is too long") {
    NetLimits limits;
    limits.handlers = 2;
    limits.waitTimeout = 300ms;
    NetServer server(limits);
    Clients busy;
    for (int i = 0; i < 2; ++i) {
        busy.push_back(std::make_unique<RawClient>(server.address));
        busy.back()->send(get("/slow"));
    }
    REQUIRE(eventually([&] { return server.running == 2; }));
    RawClient late(server.address);
    late.send(get("/quick"));
    CHECK(statusOf(late.readAnswer()) == 503);
    RawClient patient(server.address);
    patient.send(get("/quick"));
    CHECK(patient.readAnswer(50ms).empty());
    server.open = true;
    CHECK(statusOf(patient.readAnswer()) == 200);
}

TEST_CASE("Front: 64 connections at once are all answered within a second, long ones besides") {
    NetServer server;
    Clients busy;
    for (int i = 0; i < 20; ++i) {
        busy.push_back(std::make_unique<RawClient>(server.address));
        busy.back()->send(get("/slow"));
    }
    const auto began = std::chrono::steady_clock::now();
    Clients burst;
    for (int i = 0; i < 64; ++i) burst.push_back(std::make_unique<RawClient>(server.address));
    for (const auto& client : burst) client->send(get("/quick"));
    for (const auto& client : burst) CHECK(statusOf(client->readAnswer()) == 200);
    CHECK(std::chrono::steady_clock::now() - began < 1s);
    REQUIRE(eventually([&] { return server.running == 20; }));
}

TEST_CASE("Front: a client that ends its sending still gets its answers") {
    const NetServer server;
    for (const char* path : {"/quick", "/lent"}) {
        RawClient client(server.address);
        client.send(get(path) + get("/quick"));
        client.endSending();
        CHECK(statusOf(client.readAnswer(20s)) == 200);
        CHECK(client.readAnswer().ends_with("quick"));
        CHECK(client.closedWithin(1s));
    }
}

// A connection that was never waited for in epoll was registered there all the same; the event of
// its client leaving came after it was gone.
TEST_CASE("regression: clients that leave before their answer are forgotten once") {
    const NetServer server;
    for (int round = 0; round < 20; ++round) {
        Clients clients;
        for (int i = 0; i < 20; ++i) {
            clients.push_back(std::make_unique<RawClient>(server.address));
            clients.back()->send(get("/quick", i % 2 ? "Connection: close\r\n" : ""));
        }
    }
    CHECK(eventually([&] {
        return server.front->stats().accepted == 400 && server.count(Phase::idle) +
                                                                server.count(Phase::handler) +
                                                                server.count(Phase::closing) ==
                                                            0;
    }));
    CHECK(quickMilliseconds(server.address) < 1000);
}

TEST_CASE("clientLeft: sees a client go, also behind a pipelined request") {
    const NetServer server;
    RawClient client(server.address);
    client.send(get("/watch") + get("/quick"));
    REQUIRE(eventually([&] { return server.running == 1; }));
    std::this_thread::sleep_for(30ms);
    CHECK(server.running == 1);
    client.close();
    CHECK(eventually([&] { return server.gone == 1; }));
}

TEST_CASE("Front: a refused body is not waited for; a small one that is here costs nothing") {
    const NetServer server;
    RawClient small(server.address);
    small.send(sized("/refuse", std::string(1000, 'x')) + get("/quick"));
    CHECK(small.readAnswer().find("Connection: close") == std::string::npos);
    CHECK(statusOf(small.readAnswer()) == 200);

    for (const std::string& headers :
         {std::string("Content-Length: 1000\r\n"), std::string("Content-Length: 100000000\r\n"),
          std::string("Transfer-Encoding: chunked\r\n"),
          std::string("Expect: 100-continue\r\nContent-Length: 5\r\n")}) {
        CAPTURE(headers);
        RawClient client(server.address);
        client.send(post("/refuse", headers, "x"));
        const std::string answer = client.readUntil("\r\n\r\nno");
        CHECK(answer.find("403") != std::string::npos);
        CHECK(answer.find("Connection: close") != std::string::npos);
        CHECK(eventually([&] { return server.front->stats().activeRequests == 0; }));
    }
}

// A close with unread bytes resets the connection; the answer may be lost on the other side.
TEST_CASE("Front: an answer survives the bytes that nobody read, and no reset follows it") {
    const NetServer server;
    for (int i = 0; i < 5; ++i) {
        RawClient client(server.address);
        CHECK(client.send(post("/refuse", "Content-Length: 900000\r\n", std::string(800000, 'x'))));
        CHECK(client.readAnswer().ends_with("no"));
        for (int more = 0; more < 3; ++more) {
            std::this_thread::sleep_for(10ms);
            CHECK(client.send("x"));
        }
        CHECK(client.closedWithin(3s));
    }
}

// A proxy that passes a large body on looks for the answer only when it cannot write.
TEST_CASE(
    "regression: who sends a body that is not wanted is held back, and not reset while it does") {
    server::NetLimits limits;
    limits.lingerBytes = 64 << 10;
    const NetServer server(limits);
    RawClient client(server.address);
    REQUIRE(client.send("POST /refuse HTTP/1.1\r\nHost: x\r\nContent-Length: 1000000000\r\n\r\n"));
    const std::string piece(std::size_t{64} << 10, 'x');
    ssize_t sent = 0;
    for (int i = 0; i < 4000 && sent >= 0; ++i) {
        sent = ::send(client.fd(), piece.data(), piece.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
        if (sent < 0) CHECK(errno == EAGAIN);
    }
    CHECK(sent < 0);
    CHECK(statusOf(client.readAnswer()) == 403);
}

TEST_CASE("reject: framings that smuggle requests are refused and the connection closed") {
    const NetServer server;
    const std::string hidden = "0\r\n\r\n" + get("/quick");
    for (const std::string& request :
         {post("/upload", "Content-Length: 5\r\nContent-Length: 5\r\n", hidden),
          post("/upload", "Content-Length: 5\r\nContent-Length: 6\r\n", hidden),
          post("/upload", "Content-Length: 5\r\nTransfer-Encoding: chunked\r\n", hidden),
          post("/upload", "Transfer-Encoding: chunked\r\n", "-2\r\nab\r\n" + hidden),
          post("/upload", "Transfer-Encoding: gzip\r\n", hidden),
          post("/upload", "Content-Length: 5\r\n folded: x\r\n", hidden),
          post("/upload", "Content-Length: 5\r\nX: a\nY: b\r\n", hidden),
          post("/upload", "Content-Length: 5\r\nX: a\rY: b\r\n", hidden),
          post("/upload", "Content-Length: 5\r\nX: " + std::string(1, '\0') + "\r\n", hidden),
          post("/upload", "Content-Length : 5\r\n", hidden),
          post("/upload", "Content-Length: 0x5\r\n", hidden)}) {
        CAPTURE(request);
        RawClient client(server.address);
        client.send(request);
        CHECK(statusOf(client.readAnswer()) == 400);
        CHECK(client.closedWithin(1s));
    }
}

TEST_CASE("Front: a connection ends when it has asked often enough, or says so") {
    NetLimits limits;
    limits.requestsPerConnection = 3;
    const NetServer server(limits);
    RawClient client(server.address);
    client.send(get("/quick") + get("/quick") + get("/quick") + get("/quick"));
    CHECK(client.readAnswer().find("Connection: close") == std::string::npos);
    CHECK(client.readAnswer().find("Connection: close") == std::string::npos);
    CHECK(client.readAnswer().find("Connection: close") != std::string::npos);
    CHECK(client.closedWithin(1s));
    RawClient polite(server.address);
    polite.send(get("/quick", "Connection: close\r\n"));
    CHECK(polite.readAnswer().ends_with("quick"));
    CHECK(polite.closedWithin(1s));
    RawClient old(server.address);
    old.send("GET /quick HTTP/1.0\r\n\r\n");
    CHECK(old.readAnswer().ends_with("quick"));
    CHECK(old.closedWithin(1s));
}

TEST_CASE("Front: out of descriptors it sheds connections, does not spin, and lives on") {
    const NetServer server;
    Clients clients;
    for (int i = 0; i < 5; ++i) clients.push_back(std::make_unique<RawClient>(server.address));
    REQUIRE(server.waitFor(Phase::header, 5));
    clients.clear();
    REQUIRE(server.waitFor(Phase::header, 0));
    // Sockets that are ready to connect, then no descriptor for the other side.
    std::vector<server::Fd> sockets;
    for (int i = 0; i < 3; ++i) sockets.emplace_back(::socket(AF_INET, SOCK_STREAM, 0));
    rlimit before{};
    ::getrlimit(RLIMIT_NOFILE, &before);
    rlimit tight = before;
    tight.rlim_cur = 200;
    ::setrlimit(RLIMIT_NOFILE, &tight);
    std::vector<server::Fd> filling;
    for (server::Fd fd(::dup(0)); fd; fd = server::Fd(::dup(0))) filling.push_back(std::move(fd));
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_port = htons(static_cast<std::uint16_t>(server.address.port));
    name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    for (const server::Fd& fd : sockets) {
        REQUIRE(::connect(fd.get(), reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0);
        char byte = 0;
        CHECK(::recv(fd.get(), &byte, 1, 0) <= 0);
    }
    filling.clear();
    ::setrlimit(RLIMIT_NOFILE, &before);
    CHECK(quickMilliseconds(server.address) < 1000);
}

TEST_CASE("Front: shows that it is alive") {
    const NetServer server;
    for (int i = 0; i < 5; ++i) {
        std::this_thread::sleep_for(60ms);
        CHECK(std::chrono::steady_clock::now() - server.front->lastBeat() < 500ms);
    }
}

TEST_SUITE_END();
