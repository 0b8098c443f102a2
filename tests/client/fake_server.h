#pragma once

#include <httplib.h>

#include <unistd.h>
#include <atomic>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

namespace rivage::client {

/// A folder of its own for one test case, gone at its end.
class TemporaryFolder {
public:
    TemporaryFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "rivage-test.XXXXXX").string();
        path_ = mkdtemp(name.data());
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path_); }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    [[nodiscard]] std::string operator/(const std::string& name) const {
        return path_ + "/" + name;
    }
    [[nodiscard]] std::size_t entries() const {
        const std::filesystem::directory_iterator begin(path_);
        return static_cast<std::size_t>(std::distance(begin, {}));
    }

private:
    std::string path_;
};

/// A server on a free loopback port that answers as the test tells it to. Handlers are added
/// through `http` before `start`.
class FakeServer {
public:
    ~FakeServer() {
        http.stop();
        if (thread_.joinable()) thread_.join();
    }
    void start() {
        port_ = http.bind_to_any_port("127.0.0.1");
        thread_ = std::thread([this] { http.listen_after_bind(); });
        http.wait_until_ready();
    }
    [[nodiscard]] std::string url() const { return "http://127.0.0.1:" + std::to_string(port_); }
    [[nodiscard]] int port() const { return port_; }

    httplib::Server http;

private:
    int port_ = 0;
    std::thread thread_;
};

/// Handlers that take a job and let it succeed at once with `result`, counting what comes in.
struct FakeJobs {
    std::string id = "0190aaaa-0000-7000-8000-000000000001";
    std::string state = "succeeded";
    std::string error = "null";
    std::string result = "glTF and the rest";
    std::string report = R"({"output":{"media_type":"model/gltf-binary"}})";
    std::atomic<int> posts{0};
    std::atomic<int> polls{0};
    std::atomic<int> deletes{0};
    httplib::Request lastPost;
    mutable std::mutex mutex;  ///< of all but the counts, while requests may come

    void become(std::string nextState, std::string nextError = "null") {
        const std::lock_guard lock(mutex);
        state = std::move(nextState);
        error = std::move(nextError);
    }
    [[nodiscard]] std::string lastBody() const {
        const std::lock_guard lock(mutex);
        return lastPost.body;
    }
    [[nodiscard]] std::string job() const {
        return R"({"id":")" + id + R"(","state":")" + state +
               R"(","stage":"solve","progress":0.5,)" + R"("queue_position":null,"report":)" +
               report + R"(,"error":)" + error + "}";
    }
    void addTo(httplib::Server& server) {
        server.Post("/v1/jobs",
                    [this](const httplib::Request& request, httplib::Response& response) {
                        const std::lock_guard lock(mutex);
                        ++posts;
                        lastPost = request;
                        response.status = 202;
                        response.set_content(job(), "application/json");
                    });
        const std::string path = "/v1/jobs/" + id;
        server.Get(path, [this](const httplib::Request&, httplib::Response& response) {
            const std::lock_guard lock(mutex);
            ++polls;
            response.set_content(job(), "application/json");
        });
        server.Get(path + "/result", [this](const httplib::Request&, httplib::Response& response) {
            const std::lock_guard lock(mutex);
            response.set_content(result, "model/gltf-binary");
        });
        server.Delete(path, [this](const httplib::Request&, httplib::Response& response) {
            ++deletes;
            response.status = 204;
        });
    }
};

}  // namespace rivage::client
