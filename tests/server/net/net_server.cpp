#include "tests/server/net/net_server.h"

#include <doctest/doctest.h>

#include <utility>

namespace rivage::test {

using namespace std::chrono_literals;
using server::NetLimits;

NetServer::NetServer(const NetLimits& limits, const server::TlsContext* tls) {
    begin(limits, server::listenOn({"127.0.0.1", 0, ""}).value(), tls);
}

NetServer::NetServer(const NetLimits& limits, server::Listener listener) {
    begin(limits, std::move(listener), nullptr);
}

void NetServer::begin(const NetLimits& limits, server::Listener listener,
                      const server::TlsContext* tls) {
    setRoutes();
    setBigRoutes();
    front = std::make_unique<server::Front>(limits, engine,
                                            [this](int, const std::string&) { ++refused; });
    address = listener.address;
    REQUIRE(front->start(std::move(listener), tls));
}

void NetServer::setRoutes() {
    engine.Get("/quick", [](const httplib::Request&, httplib::Response& response) {
        response.set_content("quick", "text/plain");
    });
    engine.Get("/slow", [this](const httplib::Request&, httplib::Response& response) {
        ++running;
        while (!open) std::this_thread::sleep_for(1ms);
        --running;
        response.set_content("slow", "text/plain");
    });
    engine.Get("/watch", [this](const httplib::Request& request, httplib::Response& response) {
        ++running;
        bool left = false;
        while (!open && !left) {
            std::this_thread::sleep_for(1ms);
            left = server::clientLeft(request);
        }
        if (left) ++gone;
        --running;
        response.set_content("watched", "text/plain");
    });
    engine.Post("/upload", [](const httplib::Request& request, httplib::Response& response,
                              const httplib::ContentReader& body) {
        std::size_t size = 0;
        const bool complete = body([&](const char*, std::size_t bytes) {
            size += bytes;
            return true;
        });
        response.status = complete ? 200 : server::bodyTimedOut(request) ? 408 : 400;
        response.set_content(std::to_string(size), "text/plain");
    });
    engine.Post("/refuse", [](const httplib::Request&, httplib::Response& response,
                              const httplib::ContentReader&) {
        response.status = 403;
        response.set_content("no", "text/plain");
    });
}

void NetServer::setBigRoutes() {
    const auto provide = [bytes = big](std::size_t offset, std::size_t length,
                                       httplib::DataSink& sink) {
        return sink.write(bytes->data() + offset, length);
    };
    engine.Get("/lent", [this, provide](const httplib::Request&, httplib::Response& response) {
        response.set_content_provider(big->size(), "text/plain", provide);
        server::lendBytes(response, big, std::as_bytes(std::span(*big)));
    });
    engine.Get("/copied", [this, provide](const httplib::Request&, httplib::Response& response) {
        response.set_content_provider(big->size(), "text/plain", provide);
    });
    engine.Get("/stream", [this](const httplib::Request&, httplib::Response& response) {
        ++running;
        response.set_chunked_content_provider(
            "text/plain",
            [this](std::size_t, httplib::DataSink& sink) {
                std::this_thread::sleep_for(1ms);
                return !open && sink.write("0123456789", 10);
            },
            [this](bool) { --running; });
    });
}

bool NetServer::waitFor(server::Phase phase, std::size_t expected) const {
    return eventually([&] { return count(phase) == expected; });
}

bool eventually(const std::function<bool()>& holds) {
    for (int i = 0; i < 5000; ++i) {
        if (holds()) return true;
        std::this_thread::sleep_for(1ms);
    }
    return false;
}

double quickMilliseconds(const server::Address& address) {
    const auto began = std::chrono::steady_clock::now();
    RawClient client(address);
    client.send(get("/quick"));
    if (statusOf(client.readAnswer()) != 200) return 1e9;
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began)
        .count();
}

}  // namespace rivage::test
