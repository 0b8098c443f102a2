#include "tests/server/test_server.h"

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

namespace rivage::test {
namespace {

using namespace std::chrono_literals;

void sendAll(int socket, const std::string& bytes) {
    std::size_t sent = 0;
    while (sent < bytes.size()) {
        const ssize_t n = ::send(socket, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
        if (n <= 0) return;
        sent += static_cast<std::size_t>(n);
    }
}

/// Whether an answer other than 100 has all the bytes that it announces.
bool isComplete(std::string answer) {
    if (answer.starts_with("HTTP/1.1 100"))
        answer.erase(0, std::min(answer.find("\r\n\r\n"), answer.size() - 4) + 4);
    const std::size_t head = answer.find("\r\n\r\n");
    const std::size_t length = answer.find("Content-Length: ");
    if (head == std::string::npos || length > head) return false;
    return answer.size() >= head + 4 + std::stoul(answer.substr(length + 16));
}

}  // namespace

TestServer::TestServer(const TestSettings& settings) {
    server::PoolSettings poolSettings;
    poolSettings.workers = settings.workers;
    poolSettings.queueLimit = settings.queueLimit;
    poolSettings.deadline = settings.deadline;
    poolSettings.store = settings.store;
    pool = std::make_unique<server::JobPool>(
        poolSettings, fakeEngine(gate),
        [this](const server::JobFacts&, const server::JobSnapshot& job) { metrics.jobEnded(job); });
    proto::ServiceLimits limits;
    limits.maxUploadBytes = settings.maxUpload;
    limits.workers = settings.workers;
    service = std::make_unique<server::Service>(*pool, limits, fakeSamples());
    service->uploads.limit = settings.uploadBudget;
    service->corsOrigins = settings.corsOrigins;
    if (!settings.keys.empty())
        service->access = std::make_shared<server::Access>(
            std::make_shared<server::KeyRing>(server::KeyRing::parse(settings.keys).value()));
    server::HttpSettings httpSettings;
    httpSettings.net = settings.net;
    httpSettings.net.bodyGrace = settings.readTimeout;
    service->metrics = [this] { return metrics.text(*service); };
    httpSettings.observer = [this](const server::RequestRecord& record) {
        metrics.requestEnded(record);
        const std::lock_guard lock(mutex_);
        seen_.push_back(record);
        ++records;
    };
    http = std::make_unique<server::HttpServer>(httpSettings, *service);
    admin = std::make_unique<server::AdminServer>(*service);
    auto listener = server::listenOn(*server::parseAddress(settings.listen)).value();
    auto adminListener = server::listenOn({"127.0.0.1", 0, ""}).value();
    address = listener.address;
    adminAddress = adminListener.address;
    REQUIRE(http->start(std::move(listener)));
    REQUIRE(admin->start(std::move(adminListener)));
}

TestServer::~TestServer() {
    pool->stopAll();
    http->stop();
    admin->stop();
    server::removeSocketFile(address);
}

std::vector<server::RequestRecord> TestServer::seen() const {
    const std::lock_guard lock(mutex_);
    return seen_;
}

httplib::Client TestServer::client() const {
    httplib::Client client(address.isUnix() ? address.path : address.host, address.port);
    if (address.isUnix()) client.set_address_family(AF_UNIX);
    client.set_read_timeout(20s);
    client.set_tcp_nodelay(true);
    return client;
}

httplib::Client TestServer::adminClient() const {
    return httplib::Client(adminAddress.host, adminAddress.port);
}

std::string TestServer::raw(const std::string& request, const std::string& trickle) const {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(address.port));
    ::inet_pton(AF_INET, address.host.c_str(), &to.sin_addr);
    std::string answer;
    if (::connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) {
        sendAll(socket, request);
        for (const char c : trickle) {
            pollfd poll{socket, POLLIN, 0};
            if (::poll(&poll, 1, 50) != 0) break;
            sendAll(socket, std::string(1, c));
        }
        char buffer[4096];
        for (ssize_t n = 0;
             !isComplete(answer) && (n = ::recv(socket, buffer, sizeof buffer, 0)) > 0;)
            answer.append(buffer, static_cast<std::size_t>(n));
    }
    ::close(socket);
    return answer;
}

bool TestServer::waitRunning(int count) const {
    for (int i = 0; i < 5000; ++i) {
        if (gate.running == count) return true;
        std::this_thread::sleep_for(1ms);
    }
    return false;
}

proto::Json bodyOf(const httplib::Result& result) {
    REQUIRE(result);
    const auto json = proto::readJson(result->body, "", {.maxBytes = 1 << 20});
    REQUIRE_MESSAGE(json, result->body);
    return *json;
}

void checkProblem(const httplib::Result& result, int status, const std::string& slug) {
    REQUIRE(result);
    CHECK(result->status == status);
    CHECK(result->get_header_value("Content-Type") == "application/problem+json");
    CHECK_FALSE(result->get_header_value("X-Request-ID").empty());
    const proto::Json problem = bodyOf(result);
    CHECK(problem["type"] == "/problems/" + slug);
    CHECK(problem["status"] == status);
    CHECK(problem.contains("title"));
    if (status == 503) CHECK_FALSE(result->get_header_value("Retry-After").empty());
}

}  // namespace rivage::test
