#include "client/load/carrier.h"

#include <doctest/doctest.h>

#include <atomic>
#include <vector>

#include "client/load/stub_server.h"
#include "client/load/taxonomy.h"
#include "few_files.h"
#include "scripted_server.h"

namespace rivage::client::load {
namespace {

using namespace std::chrono_literals;

const std::string kRequest = "GET / HTTP/1.1\r\nHost: x\r\n\r\n";
const std::string kGood = "HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\nok";

/// Counts the ends of exchanges, and may break one off as it grows.
class Listener : public ExchangeListener {
public:
    void grown(Exchange& exchange) override {
        if (carrier != nullptr) carrier->abort(exchange);
    }
    void ended(Exchange&) override { ++ends; }
    int ends = 0;
    Carrier* carrier = nullptr;
};

Target targetOf(const std::string& url) { return *resolveTarget(*parseEndpoint(url)); }

/// Carries one exchange to its end.
void carry(Carrier& carrier, Listener& listener, Exchange& exchange,
           const std::string& head = kRequest) {
    exchange.head = head;
    exchange.keep = Keep::all;
    const int before = listener.ends;
    carrier.begin(exchange);
    const TimePoint end = Clock::now() + 10s;
    while (listener.ends == before && Clock::now() < end) carrier.poll(Clock::now() + 10ms);
    REQUIRE(listener.ends == before + 1);
}

/// The class of what becomes of one request to a server.
std::string classAt(const std::string& url, CarrierLimits limits = {}) {
    const Target target = targetOf(url);
    Listener listener;
    Carrier carrier(target, limits, listener);
    Exchange exchange;
    carry(carrier, listener, exchange);
    return errorClass(exchange);
}

/// The same for a server that reads the head and writes a text; with a reset at its end if wanted.
std::string classOf(const std::string& text, bool reset = false, CarrierLimits limits = {}) {
    const ScriptedServer server([&](const ScriptedConnection& client) {
        (void)client.readHead();
        client.write(text);
        // A reset would overtake what has just been written.
        std::this_thread::sleep_for(reset ? 50ms : 0ms);
        if (reset) client.reset();
    });
    return classAt(server.url(), limits);
}

std::string problem(int status, const std::string& slug) {
    const std::string body = R"({"type":"/problems/)" + slug + R"(","title":"x"})";
    return "HTTP/1.1 " + std::to_string(status) +
           " x\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
}

TEST_SUITE("client/load") {
    TEST_CASE("taxonomy: each misbehaviour has a class of its own") {
        CHECK(classOf(kGood).empty());
        CHECK(classOf("HTTP/1.1 204 x\r\n\r\n").empty());
        CHECK(classOf("HTTP/1.1 302 x\r\nContent-Length: 0\r\n\r\n") == "unexpected 302");
        CHECK(classOf(problem(413, "too-large")) == "413 too-large");
        CHECK(classOf(problem(429, "quota-exceeded")) == "429 quota-exceeded");
        CHECK(classOf(problem(503, "busy")) == "503-shed busy");
        CHECK(classOf(problem(500, "internal")) == "500 internal");
        CHECK(classOf(problem(400, "a b<script>")) == "400");
        CHECK(classOf("HTTP/1.1 502 x\r\nContent-Length: 3\r\n\r\nbad") == "502");
        CHECK(classOf("SSH-2.0\r\n\r\n") == "malformed-answer");
        CHECK(classOf("") == "reset-before-response");
        CHECK(classOf("", true) == "reset-before-response");
        CHECK(classOf("HTTP/1.1 200 OK\r\nConte") == "reset-before-response");
        CHECK(classOf("HTTP/1.1 200 OK\r\nContent-Length: 9\r\n\r\nshort") == "short-body");
        CHECK(classOf("HTTP/1.1 200 OK\r\nContent-Length: 9\r\n\r\nshort", true) ==
              "reset-mid-body");
        CHECK(classOf("HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nhel") ==
              "short-body");
    }

    TEST_CASE("taxonomy: nobody there, no answer, no room") {
        CHECK(classAt("http://127.0.0.1:1") == "connect-refused");
        CHECK(classAt("unix:/nonexistent/socket") == "connect-refused");
        CHECK(classAt("http://127.0.0.1:1", {.connections = 0}) == "not-sent");
        std::atomic<bool> over{false};
        const ScriptedServer silent([&](const ScriptedConnection& client) {
            (void)client.readHead();
            while (!over) std::this_thread::sleep_for(5ms);
        });
        CHECK(classAt(silent.url(), {.timeout = 100ms}) == "timeout");
        over = true;
    }

    TEST_CASE("carrier: a connection without a file is not sent, and a shortage") {
        const StubServer stub({});
        const Target target = targetOf(stub.url());
        Listener listener;
        Carrier carrier(target, {}, listener);
        Exchange exchange;
        {
            const FewFiles none(0);
            carry(carrier, listener, exchange);
        }
        CHECK(exchange.fault == Fault::notSent);
        CHECK(carrier.shortage().count == 1);
        CHECK(carrier.shortage().error == EMFILE);
        carry(carrier, listener, exchange);
        CHECK(exchange.fault == Fault::none);
    }

    TEST_CASE(
        "carrier: without a file for what it needs itself it is not ready, and ends at once") {
        const StubServer stub({});
        const Target target = targetOf(stub.url());
        for (const int left : {0, 1}) {
            const FewFiles few(left);
            Listener listener;
            Carrier carrier(target, {}, listener);
            CHECK_FALSE(carrier.ready());
            CHECK(carrier.shortage().error == EMFILE);
            Exchange exchange;
            exchange.head = kRequest;
            carrier.begin(exchange);
            CHECK(listener.ends == 1);
            CHECK(exchange.fault == Fault::notSent);
        }
    }

    TEST_CASE("carrier: keeps connections, and opens a new one for each if told to") {
        const StubServer stub({});
        const Target target = targetOf(stub.url());
        for (const bool keepAlive : {true, false}) {
            Listener listener;
            Carrier carrier(target, {.keepAlive = keepAlive}, listener);
            Exchange exchange;
            for (int i = 0; i < 5; ++i) carry(carrier, listener, exchange);
            CHECK(carrier.opened() == (keepAlive ? 1 : 5));
            CHECK(exchange.reused == keepAlive);
        }
    }

    TEST_CASE("carrier: a connection that the server has just closed is not the server's fault") {
        const ScriptedServer server([](const ScriptedConnection& client) {
            (void)client.readHead();
            client.write(kGood);
            // Another request is taken and dropped, as by a server that was about to close.
            if (client.readHead().find("second") == std::string::npos) return;
        });
        const Target target = targetOf(server.url());
        Listener listener;
        Carrier carrier(target, {}, listener);
        Exchange first;
        carry(carrier, listener, first);
        Exchange second;
        carry(carrier, listener, second, "GET /second HTTP/1.1\r\n\r\n");
        CHECK(second.fault == Fault::none);
        CHECK(second.retried);
        CHECK(carrier.opened() == 2);
    }

    TEST_CASE("carrier: an answer that comes before the request has left counts") {
        const ScriptedServer server([](const ScriptedConnection& client) {
            (void)client.readHead();
            client.write(problem(413, "too-large"));
            std::this_thread::sleep_for(100ms);
        });
        const Target target = targetOf(server.url());
        Listener listener;
        Carrier carrier(target, {}, listener);
        Exchange exchange;
        const std::string body(32 << 20, 'x');
        exchange.body = body;
        carry(carrier, listener, exchange, "POST / HTTP/1.1\r\nContent-Length: 33554432\r\n\r\n");
        CHECK(errorClass(exchange) == "413 too-large");
        CHECK_FALSE(exchange.reused);
    }

    TEST_CASE("regression: interim answers and trailers without end kept the thread for ever") {
        std::string interim;
        while (interim.size() < (1 << 20)) interim += "HTTP/1.1 102 x\r\n\r\n";
        CHECK(classOf(interim) == "malformed-answer");
        std::string trailer = "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n";
        while (trailer.size() < (1 << 20)) trailer += "X: y\r\n";
        CHECK(classOf(trailer) == "malformed-answer");
    }

    TEST_CASE("carrier: phases follow each other") {
        const ScriptedServer server([](const ScriptedConnection& client) {
            (void)client.readHead();
            std::this_thread::sleep_for(50ms);
            client.write(kGood.substr(0, kGood.size() - 1));
            std::this_thread::sleep_for(50ms);
            client.write(kGood.substr(kGood.size() - 1));
        });
        const Target target = targetOf(server.url());
        Listener listener;
        Carrier carrier(target, {}, listener);
        Exchange exchange;
        carry(carrier, listener, exchange);
        CHECK(exchange.begun < exchange.connected);
        CHECK(exchange.connected <= exchange.written);
        CHECK(exchange.firstByte - exchange.written > 40ms);
        CHECK(exchange.ended - exchange.firstByte > 40ms);
    }

    TEST_CASE("carrier: a slow client takes its time") {
        const StubServer stub({.bodySize = 1000});
        const Target target = targetOf(stub.url());
        Listener listener;
        Carrier carrier(target, {}, listener);
        Exchange exchange;
        exchange.bytesPerSecond = 4000;
        carry(carrier, listener, exchange);
        CHECK(exchange.fault == Fault::none);
        CHECK(exchange.answer.body().size() == 1000);
        CHECK(exchange.ended - exchange.begun > 200ms);
    }

    TEST_CASE("carrier: a listener may break off what it sees grow") {
        std::atomic<bool> over{false};
        const ScriptedServer server([&](const ScriptedConnection& client) {
            (void)client.readHead();
            client.write("HTTP/1.1 200 OK\r\n\r\nevent: one\n");
            while (!over) std::this_thread::sleep_for(5ms);
        });
        const Target target = targetOf(server.url());
        Listener listener;
        Carrier carrier(target, {}, listener);
        listener.carrier = &carrier;
        Exchange exchange;
        exchange.streamed = true;
        carry(carrier, listener, exchange);
        CHECK(exchange.fault == Fault::aborted);
        CHECK(carrier.active() == 0);
        over = true;
    }
}

}  // namespace
}  // namespace rivage::client::load
