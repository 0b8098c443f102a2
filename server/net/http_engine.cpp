#include "server/net/http_engine.h"

#include <algorithm>
#include <string>
#include <utility>

#include "server/net/answer.h"
#include "server/net/connection_stream.h"

namespace rivage::server {
namespace {

constexpr const char* kLent = "lent";

/// The connection of a request. It travels in a field that cpp-httplib leaves to its clients, so
/// that no table of requests is needed.
struct Carrier {
    ConnectionStream* stream;
    bool operator()(const httplib::Response&) const { return true; }
};

ConnectionStream* streamOf(const httplib::Request& request) {
    const Carrier* carrier = request.response_handler.target<Carrier>();
    return carrier ? carrier->stream : nullptr;
}

bool asksToClose(const httplib::Request& request) {
    std::string value = request.get_header_value("Connection");
    std::transform(value.begin(), value.end(), value.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c | 0x20) : c; });
    return request.version != "HTTP/1.1" || value.find("close") != std::string::npos;
}

/// Whether the next request begins where this one's body ends, and that place is known without
/// waiting for the client.
bool bodyIsBehind(const httplib::Request& request, const httplib::Response& response,
                  ConnectionStream& stream) {
    if (request.has_header("Transfer-Encoding"))
        return request.body_consumed_ && response.status < 400;
    const std::uint64_t length = request.get_header_value_u64("Content-Length");
    if (length == 0) return true;
    // A client that waits for 100 Continue may or may not send its body after a refusal.
    if (response.status >= 400 && request.has_header("Expect")) return false;
    return request.body_consumed_ ? stream.tookBody(length) : stream.hasBody(length);
}

}  // namespace

bool clientLeft(const httplib::Request& request) {
    const ConnectionStream* stream = streamOf(request);
    return stream ? stream->clientLeft() : request.is_connection_closed();
}

bool bodyTimedOut(const httplib::Request& request) {
    const ConnectionStream* stream = streamOf(request);
    return stream && stream->bodyTimedOut();
}

void lendBytes(httplib::Response& response, std::shared_ptr<const void> owner,
               std::span<const std::byte> bytes) {
    response.user_data.set(
        kLent, Lent{std::move(owner), {reinterpret_cast<const char*>(bytes.data()), bytes.size()}});
}

HttpEngine::HttpEngine() {
    // The library takes an invalid listener for a stop and cuts answers off; ours is elsewhere.
    svr_sock_ = 0;
    set_post_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
        settle(request, response);
        if (onAnswer_) onAnswer_(request, response);
    });
}

/// Decides whether the connection lives on. The library would close it after each error, and would
/// read a refused body to its end.
void HttpEngine::settle(const httplib::Request& request, httplib::Response& response) {
    ConnectionStream* stream = streamOf(request);
    if (!stream) return;  // the head was malformed: the library has said close
    if (response.content_provider_ && response.content_length_ == 0) stream->beginStreaming();
    if (const Lent* lent = response.user_data.get<Lent>(kLent)) stream->lend(*lent);
    const bool keep = stream->mayKeep() && !asksToClose(request) && response.status != 408 &&
                      bodyIsBehind(request, response, *stream);
    stream->setKeep(keep);
    response.headers.erase("Connection");
    if (keep) return;
    response.headers.erase("Keep-Alive");
    response.set_header("Connection", "close");
}

void HttpEngine::answer(Connection& connection, const NetLimits& limits,
                        const std::atomic<bool>& stopping) {
    ++connection.requests;
    connection.mark.enter(Phase::handler);
    ConnectionStream stream(connection, limits, stopping);
    bool closed = false;
    const bool written = process_request(
        stream, connection.host, connection.port, {}, 0, false, closed,
        [&](httplib::Request& request) { request.response_handler = Carrier{&stream}; });
    connection.keep = written && !closed && stream.keep();
    connection.failed = connection.failed || !written;
}

}  // namespace rivage::server
