#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <thread>

#include "tests/client/bad_server.h"

namespace rivage::client {

using namespace std::chrono_literals;

TEST_SUITE_BEGIN("client");

TEST_CASE("sha256: as RFC 9530 writes it") {
    CHECK(digestOf("abc") == "sha-256=:ungWv48Bz+pBQUDeXa4iI7ADYaOWF3qctBD/YfIAFa0=:");
    CHECK(contradicts("sha-512=:xx:, " + digestOf("abd"), digestOf("abc")));
    CHECK_FALSE(contradicts("sha-512=:xx:, " + digestOf("abc"), digestOf("abc")));
    CHECK_FALSE(contradicts("", digestOf("abc")));
}

TEST_CASE("misbehaving: a result that breaks off once goes on where it broke") {
    const std::string bytes = manyBytes(1);
    BadServer server([&](const std::string& request, const RawConnection& connection, int number) {
        const std::size_t from = rangeOf(request);
        if (number == 1)
            return connection.send(ResultAnswer{.bytes = bytes, .until = 20'000}.text());
        connection.send(ResultAnswer{.bytes = bytes, .from = from}.text());
    });
    Run run;
    server.regularize(run);
    CHECK(run.code == ExitCode::ok);
    CHECK(server.result() == bytes);
    const auto requests = server.requests(std::string("GET /v1/jobs/") + kId + "/result");
    REQUIRE(requests.size() == 2);
    CHECK(requests[0].find("Range") == std::string::npos);
    CHECK(rangeOf(requests[1]) > 0);
    CHECK(rangeOf(requests[1]) <= 20'000);
    const std::string field = "\r\nIf-Range: \"one\"\r\n";
    const std::size_t at = requests[1].find(field);
    CHECK(at < requests[1].find("\r\n\r\n"));
    CHECK(requests[1].find("If-Range") == at + 2);
    CHECK(requests[1].find("If-Range", at + field.size()) == std::string::npos);
}

TEST_CASE(
    "misbehaving: a result that breaks off at every 5000 bytes arrives, as each try brings more") {
    const std::string bytes = manyBytes(2);
    BadServer server([&](const std::string& request, const RawConnection& connection, int) {
        const std::size_t from = rangeOf(request);
        connection.send(ResultAnswer{.bytes = bytes, .from = from, .until = from + 5000}.text());
    });
    Run run;
    server.regularize(run);
    CHECK(run.code == ExitCode::ok);
    CHECK(server.result() == bytes);
    CHECK(server.results >= 12);
}

TEST_CASE("misbehaving: a result that always breaks off at the same place") {
    const std::string bytes = manyBytes(3);
    BadServer server([&](const std::string& request, const RawConnection& connection, int) {
        const std::size_t from = rangeOf(request);
        connection.send(ResultAnswer{.bytes = bytes, .from = from, .until = 20'000}.text());
    });
    Run run;
    server.regularize(run);
    CHECK(run.code == ExitCode::unreachable);
    CHECK(server.leftNothing());
    CHECK(saysRecovery(run));
}

TEST_CASE("misbehaving: a server without ranges sends all of it again") {
    const std::string bytes = manyBytes(4);
    BadServer server([&](const std::string&, const RawConnection& connection, int number) {
        ResultAnswer answer{.bytes = bytes};
        if (number == 1) answer.until = 20'000;
        connection.send(answer.text());
    });
    Run run;
    server.regularize(run);
    CHECK(run.code == ExitCode::ok);
    CHECK(server.result() == bytes);
}

TEST_CASE("misbehaving: the result changes between two parts") {
    const std::string first = manyBytes(5);
    const std::string second = manyBytes(6);
    BadServer honest([&](const std::string&, const RawConnection& connection, int number) {
        if (number == 1)
            return connection.send(ResultAnswer{.bytes = first, .until = 30'000}.text());
        connection.send(ResultAnswer{.bytes = second, .etag = "\"two\""}.text());
    });
    Run run;
    honest.regularize(run);
    CHECK(run.code == ExitCode::ok);
    CHECK(honest.result() == second);

    // One that ignores If-Range: the part of another representation must not be sewn on.
    BadServer sloppy([&](const std::string& request, const RawConnection& connection, int number) {
        const std::size_t from = rangeOf(request);
        if (number == 1)
            return connection.send(ResultAnswer{.bytes = first, .until = 30'000}.text());
        connection.send(ResultAnswer{.bytes = second, .etag = "\"two\"", .from = from}.text());
    });
    Run again;
    sloppy.regularize(again);
    CHECK(again.code == ExitCode::ok);
    CHECK(sloppy.result() == second);
    CHECK(sloppy.results == 3);
}

TEST_CASE("misbehaving: a part that begins elsewhere is not sewn on") {
    const std::string bytes = manyBytes(7);
    BadServer server([&](const std::string& request, const RawConnection& connection, int number) {
        const std::size_t from = rangeOf(request);
        if (number == 1)
            return connection.send(ResultAnswer{.bytes = bytes, .until = 30'000}.text());
        connection.send(ResultAnswer{.bytes = bytes, .from = from > 0 ? from + 1 : 0}.text());
    });
    Run run;
    server.regularize(run);
    CHECK(run.code == ExitCode::ok);
    CHECK(server.result() == bytes);
}

TEST_CASE("misbehaving: a digest that does not fit, once and always") {
    const std::string bytes = manyBytes(8);
    BadServer once([&](const std::string&, const RawConnection& connection, int number) {
        ResultAnswer answer{.bytes = bytes};
        if (number == 1) answer.digest = digestOf("something else");
        connection.send(answer.text());
    });
    Run run;
    once.regularize(run);
    CHECK(run.code == ExitCode::ok);
    CHECK(once.result() == bytes);
    CHECK(once.results == 2);

    BadServer always([&](const std::string&, const RawConnection& connection, int) {
        connection.send(ResultAnswer{.bytes = bytes, .digest = digestOf("something else")}.text());
    });
    Run again;
    always.regularize(again);
    CHECK(again.code == ExitCode::unreachable);
    CHECK(again.err.str().find("damaged") != std::string::npos);
    CHECK(always.leftNothing());
    CHECK(always.results == 2);
    CHECK(saysRecovery(again));
}

TEST_CASE("misbehaving: stdout and pipes get a result when it is whole, nothing of a damaged one") {
    const std::string bytes = manyBytes(8);
    for (const int bad : {1, 2}) {
        CAPTURE(bad);
        BadServer server([&](const std::string&, const RawConnection& connection, int number) {
            ResultAnswer answer{.bytes = bytes};
            if (number <= bad) answer.digest = digestOf("something else");
            connection.send(answer.text());
        });
        Run run;
        server.regularize(run, {"-o", "-"});
        CHECK(run.code == (bad == 1 ? ExitCode::ok : ExitCode::unreachable));
        CHECK((run.out.str() == (bad == 1 ? bytes : "")));

        const std::string pipe = server.folder / "pipe.glb";
        REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
        server.results = 0;
        std::string read = "not read";
        std::thread reader([&] { read = contentOf(pipe); });
        Run piped;
        server.regularize(piped, {"-o", pipe});
        reader.join();
        CHECK(piped.code == run.code);
        CHECK((read == (bad == 1 ? bytes : "")));
    }
}

TEST_CASE("misbehaving: a Content-Length that lies") {
    const std::string bytes = manyBytes(9);
    for (const std::size_t length : {bytes.size() - 100, bytes.size() + 100}) {
        CAPTURE(length);
        BadServer server([&](const std::string&, const RawConnection& connection, int) {
            connection.send(ResultAnswer{.bytes = bytes, .length = length}.text());
        });
        Run run;
        server.regularize(run);
        CHECK(run.code == ExitCode::unreachable);
        CHECK(server.leftNothing());
    }
}

TEST_CASE("misbehaving: a range that is not there (416) begins again") {
    const std::string bytes = manyBytes(10);
    BadServer server([&](const std::string& request, const RawConnection& connection, int number) {
        if (rangeOf(request) > 0)
            return connection.send(jsonAnswer(416, R"({"title":"No such range"})"));
        ResultAnswer answer{.bytes = bytes};
        if (number == 1) answer.length = bytes.size() + 1;
        connection.send(answer.text());
    });
    Run run;
    server.regularize(run);
    CHECK(run.code == ExitCode::ok);
    CHECK(server.result() == bytes);
}

TEST_CASE("misbehaving: a server that stalls, without an answer and in the middle of one") {
    const std::string bytes = manyBytes(11);
    BadServer silent(
        [](const std::string&, const RawConnection& connection, int) { connection.stall(); });
    Run run;
    run.retry.silence = 50ms;
    silent.regularize(run);
    CHECK(run.code == ExitCode::unreachable);
    CHECK(silent.results == 3);
    CHECK(silent.leftNothing());
    CHECK(saysRecovery(run));

    Run late;
    silent.regularize(late, {"--timeout", "0.3"});
    CHECK(late.code == ExitCode::busy);
    CHECK(silent.leftNothing());

    BadServer half([&](const std::string& request, const RawConnection& connection, int number) {
        const std::size_t from = rangeOf(request);
        ResultAnswer answer{.bytes = bytes, .from = from};
        if (number == 1) answer.until = 20'000;
        connection.send(answer.text());
        if (number == 1) connection.stall();
    });
    Run patient;
    patient.retry.silence = 100ms;
    half.regularize(patient);
    CHECK(patient.code == ExitCode::ok);
    CHECK(half.result() == bytes);
}

TEST_CASE("misbehaving: a POST that breaks is sent again under the same key") {
    const std::string bytes = manyBytes(12);
    const std::string job = std::string(R"({"id":")") + kId + R"(","state":"queued"})";
    BadServer server(
        [&](const std::string&, const RawConnection& connection, int) {
            connection.send(ResultAnswer{.bytes = bytes}.text());
        },
        [&](const std::string&, const RawConnection& connection, int number) {
            if (number == 1) return connection.reset();
            if (number == 2)
                return connection.send(jsonAnswer(
                    409, R"({"type":"/problems/idempotency-in-progress","title":"Later"})",
                    "Retry-After: 0\r\n"));
            connection.send(jsonAnswer(202, job));
        });
    Run run;
    server.regularize(run);
    CHECK(run.code == ExitCode::ok);
    const auto posts = server.requests("POST");
    REQUIRE(posts.size() == 3);
    const auto keyOf = [](const std::string& request) {
        const std::size_t at = request.find("Idempotency-Key: ");
        REQUIRE(at != std::string::npos);
        return request.substr(at, request.find("\r\n", at) - at);
    };
    CHECK(keyOf(posts[0]) == keyOf(posts[1]));
    CHECK(keyOf(posts[0]) == keyOf(posts[2]));
}

TEST_CASE("misbehaving: a result that is refused twice with 503") {
    const std::string bytes = manyBytes(13);
    BadServer server([&](const std::string&, const RawConnection& connection, int number) {
        if (number < 3) return connection.send(jsonAnswer(503, R"({"title":"Full"})"));
        connection.send(ResultAnswer{.bytes = bytes}.text());
    });
    Run run;
    server.regularize(run);
    CHECK(run.code == ExitCode::ok);
    CHECK(server.result() == bytes);
}

TEST_CASE("misbehaving: a server that lost the job gets it once again") {
    const std::string bytes = manyBytes(14);
    BadServer server([&](const std::string&, const RawConnection& connection, int number) {
        if (number == 1) return connection.send(jsonAnswer(404, R"({"title":"Not here"})"));
        connection.send(ResultAnswer{.bytes = bytes}.text());
    });
    Run run;
    server.regularize(run);
    CHECK(run.code == ExitCode::ok);
    CHECK(server.posts == 2);

    BadServer forgetful([&](const std::string&, const RawConnection& connection, int) {
        connection.send(jsonAnswer(404, R"({"title":"Not here"})"));
    });
    Run again;
    forgetful.regularize(again);
    CHECK(again.code == ExitCode::failed);
    CHECK(forgetful.posts == 2);
    CHECK_FALSE(saysRecovery(again));
}

TEST_CASE("misbehaving: a stop in the middle of a result") {
    const std::string bytes = manyBytes(15);
    std::atomic<bool> halfway{false};
    BadServer server([&](const std::string&, const RawConnection& connection, int) {
        connection.send(ResultAnswer{.bytes = bytes, .until = 20'000}.text());
        halfway = true;
        connection.stall();
    });
    Run run;
    std::thread person([&] {
        while (!halfway) std::this_thread::sleep_for(1ms);
        run.interrupt.request();
    });
    server.regularize(run);
    person.join();
    CHECK(run.code == ExitCode::cancelled);
    CHECK(server.leftNothing());
    CHECK_FALSE(saysRecovery(run));
}

TEST_CASE("misbehaving: a disk that is full") {
    const std::string bytes = manyBytes(16);
    BadServer server([&](const std::string&, const RawConnection& connection, int) {
        connection.send(ResultAnswer{.bytes = bytes}.text());
    });
    Run device;
    server.regularize(device, {"-o", "/dev/full"});
    CHECK(device.code == ExitCode::notWritten);
    CHECK(device.err.str().find("No space left") != std::string::npos);
    CHECK(saysRecovery(device));

    std::signal(SIGXFSZ, SIG_IGN);  // as the program does
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    rlimit small = before;
    small.rlim_cur = 10'000;
    setrlimit(RLIMIT_FSIZE, &small);
    Run run;
    server.regularize(run);
    setrlimit(RLIMIT_FSIZE, &before);
    CHECK(run.code == ExitCode::notWritten);
    CHECK(server.leftNothing());
    CHECK(saysRecovery(run));
}

TEST_SUITE_END();

}  // namespace rivage::client
