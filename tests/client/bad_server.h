#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "client/sha256.h"
#include "tests/client/fake_server.h"
#include "tests/client/raw_server.h"
#include "tests/client/run.h"

namespace rivage::client {

inline constexpr const char* kId = "0190aaaa-0000-7000-8000-000000000002";

inline std::string manyBytes(unsigned seed) {
    std::mt19937 random(seed);
    std::string bytes(60'000, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random());
    return bytes;
}

inline std::string digestOf(const std::string& bytes) {
    Sha256 digest;
    digest.update(bytes);
    return digest.field();
}

inline std::string jsonAnswer(int status, const std::string& body, const std::string& more = {}) {
    return "HTTP/1.1 " + std::to_string(status) +
           " Word\r\nContent-Type: application/json\r\nContent-Length: " +
           std::to_string(body.size()) + "\r\nConnection: close\r\n" + more + "\r\n" + body;
}

/// The head of a result, and as many of its bytes as it likes to send.
struct ResultAnswer {
    std::string bytes;
    std::string etag = "\"one\"";
    std::size_t from = 0;
    std::size_t until = std::string::npos;   ///< of what is sent
    std::size_t length = std::string::npos;  ///< what Content-Length says; npos: the truth
    std::string digest = {};                 ///< empty: the true one

    [[nodiscard]] std::string text() const {
        const bool part = from > 0;
        const std::size_t rest = bytes.size() - from;
        std::string head = part ? "HTTP/1.1 206 Partial Content\r\n" : "HTTP/1.1 200 OK\r\n";
        if (part)
            head += "Content-Range: bytes " + std::to_string(from) + "-" +
                    std::to_string(bytes.size() - 1) + "/" + std::to_string(bytes.size()) + "\r\n";
        head += "Content-Length: " + std::to_string(length == std::string::npos ? rest : length) +
                "\r\nETag: " + etag +
                "\r\nRepr-Digest: " + (digest.empty() ? digestOf(bytes) : digest) +
                "\r\nConnection: close\r\n\r\n";
        return head + bytes.substr(from, until == std::string::npos ? until : until - from);
    }
};

/// The first byte that a request asks for.
inline std::size_t rangeOf(const std::string& request) {
    constexpr std::string_view kField = "\r\nRange: bytes=";
    const std::size_t at = request.find(kField);
    return at == std::string::npos ? 0 : std::stoul(request.substr(at + kField.size()));
}

/// A server that takes a job, does it at once, and answers for its result as a test likes.
class BadServer {
public:
    using Answer =
        std::function<void(const std::string& request, const RawConnection&, int number)>;

    explicit BadServer(Answer onResult, Answer onPost = {})
        : onResult_(std::move(onResult)), onPost_(std::move(onPost)) {
        writeFile(folder / "house.vox", "VOX and more");
    }

    Run& regularize(Run& run, std::vector<std::string> more = {}) {
        run.retry.tries = 3;
        run.retry.patientTries = 3;
        std::vector<std::string> all{"regularize", folder / "house.vox", "--server", server.url()};
        all.insert(all.end(), more.begin(), more.end());
        return run(all);
    }
    [[nodiscard]] std::string result() const { return contentOf(folder / "house.glb"); }
    [[nodiscard]] bool leftNothing() const { return folder.entries() == 1; }
    [[nodiscard]] std::vector<std::string> requests(const std::string& begin) {
        const std::lock_guard lock(mutex_);
        std::vector<std::string> found;
        for (const std::string& request : requests_)
            if (request.starts_with(begin)) found.push_back(request);
        return found;
    }

    TemporaryFolder folder;
    std::atomic<int> results{0};
    std::atomic<int> posts{0};

private:
    void answer(const std::string& request, const RawConnection& connection) {
        {
            const std::lock_guard lock(mutex_);
            requests_.push_back(request);
        }
        const std::string job =
            std::string(R"({"id":")") + kId + R"(","state":"succeeded","progress":1,"report":{}})";
        if (request.starts_with("POST")) {
            if (onPost_) return onPost_(request, connection, ++posts);
            ++posts;
            connection.send(jsonAnswer(202, job));
        } else if (request.starts_with("DELETE")) {
            connection.send("HTTP/1.1 204 No Content\r\nConnection: close\r\n\r\n");
        } else if (request.find("/result ") != std::string::npos) {
            onResult_(request, connection, ++results);
        } else {
            connection.send(jsonAnswer(200, job));
        }
    }

    Answer onResult_;
    Answer onPost_;
    std::mutex mutex_;
    std::vector<std::string> requests_;

public:
    RawServer server{[this](const std::string& request, const RawConnection& connection) {
        answer(request, connection);
    }};
};

/// How to fetch the result later, which has to be said whenever the job is not lost.
inline bool saysRecovery(const Run& run) {
    return run.err.str().find(std::string("rivage jobs fetch ") + kId) != std::string::npos;
}

}  // namespace rivage::client
