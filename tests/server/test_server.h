#pragma once

#include <httplib.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "proto/json.h"
#include "server/http/admin_server.h"
#include "server/http/http_server.h"
#include "server/jobs/job_pool.h"
#include "server/ops/metrics.h"
#include "tests/server/fake_engine.h"

namespace rivage::test {

struct TestSettings {
    std::size_t workers = 2;
    std::size_t queueLimit = 8;
    std::uint64_t maxUpload = 1 << 20;
    std::chrono::milliseconds deadline{10000};
    server::StoreLimits store = {};
    std::chrono::seconds readTimeout{2};
    std::string listen = "127.0.0.1:0";
    server::NetLimits net = {};
    std::string keys = {};  ///< text of a key file; empty: everybody may call
    std::vector<std::string> corsOrigins = {};
    std::uint64_t uploadBudget = 1 << 30;
};

/// A server on a free loopback port with an engine that does what the grid says.
class TestServer {
public:
    explicit TestServer(const TestSettings& settings = {});
    ~TestServer();

    [[nodiscard]] httplib::Client client() const;
    [[nodiscard]] httplib::Client adminClient() const;
    /// One byte stream to the server, for what a well-behaved client would not send.
    /// @param trickle  sent after `request`, a byte every 50 ms, while the server says nothing
    /// @return what the server answers, up to the end of the first final answer
    [[nodiscard]] std::string raw(const std::string& request,
                                  const std::string& trickle = {}) const;

    /// Waits until so many jobs run. @return false after 5 s
    [[nodiscard]] bool waitRunning(int count) const;

    Gate gate;
    server::Metrics metrics;
    std::vector<server::RequestRecord> seen() const;
    std::unique_ptr<server::JobPool> pool;
    std::unique_ptr<server::Service> service;
    std::unique_ptr<server::HttpServer> http;
    std::unique_ptr<server::AdminServer> admin;
    server::Address address;
    server::Address adminAddress;
    std::atomic<int> records{0};

private:
    mutable std::mutex mutex_;
    std::vector<server::RequestRecord> seen_;
};

/// The JSON of an answer; fails the test if it is not JSON.
[[nodiscard]] proto::Json bodyOf(const httplib::Result& result);

/// Checks that an answer is the problem with this status and slug.
void checkProblem(const httplib::Result& result, int status, const std::string& slug);

}  // namespace rivage::test
