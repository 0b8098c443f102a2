#include "tests/fuzz/fake_connection.h"

#include <httplib.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "proto/options.h"
#include "server/http/exchange.h"
#include "server/http/prefer.h"
#include "server/http/routes.h"
#include "server/http/trace.h"
#include "server/http/upload.h"
#include "server/net/head_scanner.h"
#include "tests/fuzz/wire_check.h"

namespace rivage::fuzz {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMaxUpload = 1 << 16;  // small: the fuzzer shall reach it by inflating

/// Both ends of a connection in memory.
class MemoryStream final : public httplib::Stream {
public:
    MemoryStream(std::string_view input, std::size_t piece) : rest_(input), piece_(piece) {}

    bool is_readable() const override { return !rest_.empty(); }
    bool wait_readable() const override { return true; }
    bool wait_writable() const override { return true; }
    ssize_t read(char* to, std::size_t size) override {
        const std::size_t n = std::min({size, rest_.size(), piece_});
        if (n > 0) std::memcpy(to, rest_.data(), n);
        rest_.remove_prefix(n);
        return static_cast<ssize_t>(n);
    }
    ssize_t write(const char* from, std::size_t size) override {
        output_.append(from, size);
        return static_cast<ssize_t>(size);
    }
    void get_remote_ip_and_port(std::string& ip, int& port) const override {
        ip = "127.0.0.1";
        port = 1;
    }
    void get_local_ip_and_port(std::string& ip, int& port) const override {
        get_remote_ip_and_port(ip, port);
    }
    socket_t socket() const override { return INVALID_SOCKET; }
    time_t duration() const override { return 0; }

    [[nodiscard]] bool atEnd() const { return rest_.empty(); }
    [[nodiscard]] std::string& output() { return output_; }

private:
    std::string_view rest_;
    const std::size_t piece_;
    std::string output_;
};

server::Service& fakeService() {
    static server::JobPool pool({}, {});
    static proto::ServiceLimits limits = [] {
        proto::ServiceLimits made;
        made.maxUploadBytes = kMaxUpload;
        return made;
    }();
    static server::Service service{pool, limits};
    service.uploads.limit = std::uint64_t{8} * kMaxUpload;
    return service;
}

/// What a handler of the server does with an untrusted request, without the job.
void upload(const httplib::Request& request, httplib::Response& response,
            const httplib::ContentReader& body) {
    server::Exchange exchange{request, response, &body, fakeService()};
    server::requestId(request, response);
    static_cast<void>(server::traceOf(request, response));
    const server::Prefer prefer = server::parsePrefer(server::listField(request, "Prefer"));
    require(!prefer.wait || (*prefer.wait >= 0s && *prefer.wait <= 24h));
    static_cast<void>(server::matchesEtag(request.get_header_value("If-None-Match"), "\"0123\""));
    if (const auto checked = server::checkSubmission(request); !checked)
        return server::writeProblem(exchange, checked.error());
    if (const auto admitted = server::admitUpload(request, response, fakeService()); !admitted)
        return server::writeProblem(exchange, admitted.error());
    std::vector<proto::OptionText> query;
    for (const auto& [name, value] : server::queryOf(request)) query.push_back({name, value});
    const auto upload = server::readUpload(exchange);
    if (!upload) return server::writeProblem(exchange, upload.error());
    require(upload->grid.size() <= kMaxUpload && upload->options.size() <= kMaxUpload);
    require(upload->name.find_first_of("\r\n\"/\\") == std::string::npos);
    const auto options = proto::parseOptions(query, upload->options);
    if (!options) {
        requireGoodWireError(options.error());
        return server::writeError(exchange, options.error());
    }
    server::writeJson(response, 200, proto::toJson(*options));
    response.body += upload->name + "\n";
    response.body.append(reinterpret_cast<const char*>(upload->grid.data()), upload->grid.size());
}

/// The library's server, for its reading of one request.
class FuzzServer : public httplib::Server {
public:
    FuzzServer() {
        set_payload_max_length(kMaxUpload + (1 << 20));
        set_exception_handler([](const auto&, auto&, const std::exception_ptr&) { std::abort(); });
        Post("/upload", upload);
    }
    void answer(MemoryStream& stream) {
        bool closed = false;
        while (!closed && !stream.atEnd())
            if (!process_request(stream, "127.0.0.1", 1, "127.0.0.1", 2, false, closed, nullptr))
                break;
    }
};

}  // namespace

std::string serve(std::string_view request, std::size_t piece) {
    static FuzzServer server;
    // A head is scanned before the library sees it, in the pieces in which it comes.
    server::HeadScanner scanner;
    for (std::size_t come = 1;; come = std::min(3 * come, request.size())) {
        const auto verdict = scanner.scan(request.substr(0, come), server::NetLimits());
        require(!verdict.complete || scanner.size() <= request.size());
        if (verdict.complete || verdict.status != 0 || come >= request.size()) break;
    }
    MemoryStream stream(request, piece);
    server.answer(stream);
    return std::move(stream.output());
}

}  // namespace rivage::fuzz
