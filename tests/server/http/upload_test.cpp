#include <doctest/doctest.h>
#include <zstd.h>

#include <fstream>
#include <span>
#include <string>
#include <thread>

#include "server/jobs/digest.h"
#include "tests/server/test_server.h"
#include "tests/support/packed.h"

using namespace rivage;
using namespace rivage::test;

namespace {

constexpr const char* kBytes = "application/octet-stream";

std::string zstd(const std::string& text, int windowLog = 20) {
    ZSTD_CCtx* const context = ::ZSTD_createCCtx();
    ::ZSTD_CCtx_setParameter(context, ZSTD_c_windowLog, windowLog);
    ::ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 0);
    std::string packed(::ZSTD_compressBound(text.size()) + 64, '\0');
    ZSTD_inBuffer in{text.data(), text.size(), 0};
    ZSTD_outBuffer out{packed.data(), packed.size(), 0};
    // A frame whose size is not known at its begin has the window that was asked for.
    ::ZSTD_compressStream2(context, &out, &in, ZSTD_e_continue);
    while (::ZSTD_compressStream2(context, &out, &in, ZSTD_e_end) != 0) {
    }
    ::ZSTD_freeCCtx(context);
    packed.resize(out.pos);
    return packed;
}

std::string encoded(const std::string& encoding, const std::string& text) {
    if (encoding == "zstd") return zstd(text);
    return packed(text, encoding == "gzip");
}

std::string digestOf(const std::string& text) {
    return "sha-256=:" + server::sha256(std::as_bytes(std::span(text.data(), text.size()))).base64 +
           ":";
}

httplib::Result post(const TestServer& server, const std::string& encoding, const std::string& body,
                     httplib::Headers headers = {}, const std::string& type = kBytes) {
    headers.emplace("Content-Encoding", encoding);
    return server.client().Post("/v1/regularize", headers, body, type);
}

httplib::Result postChunked(const TestServer& server, const std::string& encoding,
                            const std::string& body) {
    return server.client().Post(
        "/v1/regularize", httplib::Headers{{"Content-Encoding", encoding}},
        [&](std::size_t offset, httplib::DataSink& sink) {
            sink.write(body.data() + offset, std::min<std::size_t>(body.size() - offset, 777));
            if (offset + 777 >= body.size()) sink.done();
            return true;
        },
        kBytes);
}

std::string form(const std::string& grid) {
    return "--b\r\nContent-Disposition: form-data; name=\"grid\"; filename=\"g.vox\"\r\n\r\n" +
           grid +
           "\r\n--b\r\nContent-Disposition: form-data; name=\"options\"\r\n\r\n{}\r\n--b--\r\n";
}

std::size_t peakResident() {
    std::ifstream file("/proc/self/status");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("VmHWM:")) return std::stoul(line.substr(6)) << 10;
    return 0;
}

/// Bytes of the peak above an earlier one. The kernel's count is behind by some pages a thread, so
/// that the later one may be the smaller.
std::size_t grownSince(std::size_t before) {
    const std::size_t now = peakResident();
    return now > before ? now - before : 0;
}

void resetPeak() { std::ofstream("/proc/self/clear_refs") << "5"; }

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("upload: gzip, deflate and zstd; plain, chunked, as a form, in several frames") {
    const TestServer server;
    const std::string grid = "ok " + std::string(100000, 'g');
    for (const std::string encoding : {"gzip", "deflate", "zstd"}) {
        CAPTURE(encoding);
        const std::string body = encoded(encoding, grid);
        for (const auto& answer :
             {post(server, encoding, body), postChunked(server, encoding, body),
              post(server, encoding, encoded(encoding, form(grid)), {},
                   "multipart/form-data; boundary=b")}) {
            REQUIRE(answer);
            CHECK(answer->status == 200);
            CHECK(answer->body == "asset of " + grid);
        }
        if (encoding == "deflate") continue;
        const auto two = post(server, encoding, encoded(encoding, "ok ") + encoded(encoding, "2"));
        REQUIRE(two);
        CHECK(two->body == "asset of ok 2");
    }
    CHECK(post(server, "GZIP", encoded("gzip", "ok"))->status == 200);
    CHECK(post(server, "identity", "ok")->status == 200);
    checkProblem(post(server, "br", "ok"), 415, "unsupported-encoding");
    checkProblem(post(server, "gzip, zstd", "ok"), 415, "unsupported-encoding");
}

TEST_CASE("upload: every prefix of an encoded body is refused, and whatever follows it") {
    const TestServer server;
    for (const std::string encoding : {"gzip", "deflate", "zstd"}) {
        CAPTURE(encoding);
        const std::string body = encoded(encoding, "ok grid");
        for (std::size_t i = 0; i < body.size(); ++i)
            checkProblem(post(server, encoding, body.substr(0, i)), 400, "malformed-request");
        for (const std::string& tail :
             {std::string("x"), std::string(4, '\0'), std::string("\x1f")})
            checkProblem(post(server, encoding, body + tail), 400, "malformed-request");
        checkProblem(post(server, encoding, "ok grid"), 400, "malformed-request");
    }
}

TEST_CASE("upload: bombs are cut at the limit, and take no more memory than it") {
    TestServer server({.maxUpload = 4 << 20});
    const std::string zeros(200 << 20, '\0');
    for (const std::string encoding : {"gzip", "deflate", "zstd"}) {
        const std::string body = encoded(encoding, zeros);
        const std::string inForm = encoded(encoding, form(zeros));
        CHECK(body.size() < 300 << 10);
        resetPeak();
        const std::size_t before = peakResident();
        checkProblem(post(server, encoding, body), 413, "too-large");
        checkProblem(postChunked(server, encoding, body), 413, "too-large");
        checkProblem(post(server, encoding, inForm, {}, "multipart/form-data; boundary=b"), 413,
                     "too-large");
        MESSAGE(encoding << ": " << body.size() << " bytes sent, peak +"
                         << (grownSince(before) >> 10) << " KiB");
        CHECK(grownSince(before) < std::size_t{48} << 20);
    }
}

TEST_CASE("upload: a zstd frame with a window above 8 MiB is refused, its window not allocated") {
    TestServer server({.maxUpload = 64 << 20});
    const std::string grid = "ok " + std::string(1 << 20, 'g');
    CHECK(post(server, "zstd", zstd(grid, 23))->status == 200);
    const std::string huge = zstd(grid, 27);
    resetPeak();
    const std::size_t before = peakResident();
    checkProblem(post(server, "zstd", huge), 400, "malformed-request");
    CHECK(grownSince(before) < std::size_t{32} << 20);
}

TEST_CASE("upload: Content-Digest is of the bytes sent, Repr-Digest of the bytes meant") {
    const TestServer server;
    const std::string grid = "ok grid";
    const std::string packed = encoded("gzip", grid);
    const auto with = [&](const std::string& encoding, const std::string& body, const char* name,
                          const std::string& digest) {
        return post(server, encoding, body, {{name, digest}});
    };
    for (const auto& [encoding, body] :
         {std::pair{std::string("identity"), grid}, {std::string("gzip"), packed}}) {
        CHECK(with(encoding, body, "Content-Digest", digestOf(body))->status == 200);
        CHECK(with(encoding, body, "Repr-Digest", digestOf(grid))->status == 200);
        CHECK(with(encoding, body, "Content-Digest", "sha-512=:AAAA:")->status == 200);
        for (const char* name : {"Content-Digest", "Repr-Digest"}) {
            const auto wrong = with(encoding, body, name, digestOf("other"));
            checkProblem(wrong, 400, "digest-mismatch");
            const auto malformed = with(encoding, body, name, "sha-256=abc");
            checkProblem(malformed, 400, "malformed-request");
            CHECK(bodyOf(malformed)["field"] == (name == std::string("Content-Digest")
                                                     ? "/headers/content-digest"
                                                     : "/headers/repr-digest"));
        }
    }
    checkProblem(with("gzip", packed, "Content-Digest", digestOf(grid)), 400, "digest-mismatch");
    checkProblem(with("gzip", packed, "Repr-Digest", digestOf(packed)), 400, "digest-mismatch");
    CHECK(server.pool->stats().jobs[static_cast<int>(proto::JobState::succeeded)] == 6);
}

TEST_CASE("upload: uploads in flight hold no more than the budget") {
    TestServer server({.maxUpload = 1 << 20, .uploadBudget = 3 << 19});
    auto client = server.client();
    const std::string head = "POST /v1/jobs HTTP/1.1\r\nHost: x\r\nContent-Length: 1048576\r\n\r\n";
    std::thread slow([&] { (void)server.raw(head + "ok", std::string(10, 'x')); });
    for (int i = 0; i < 2000 && server.service->uploads.used() == 0; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    CHECK(server.service->uploads.used() == 1 << 20);
    const auto refused = server.raw(head);  // by its length alone
    CHECK(refused.starts_with("HTTP/1.1 503"));
    CHECK(refused.find("--upload-budget") != std::string::npos);
    CHECK(refused.find("Retry-After") != std::string::npos);
    const std::string grid = "ok " + std::string(900000, 'g');
    for (const auto& answer :
         {post(server, "gzip", encoded("gzip", grid)), postChunked(server, "identity", grid)})
        checkProblem(answer, 503, "queue-full");
    CHECK(server.service->uploads.refused() == 3);
    CHECK(client.Post("/v1/regularize", "ok small", kBytes)->status == 200);
    slow.join();
    for (int i = 0; i < 5000 && server.service->uploads.used() > 0; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    CHECK(server.service->uploads.used() == 0);
    CHECK(post(server, "gzip", encoded("gzip", grid))->status == 200);
}

TEST_SUITE_END();
