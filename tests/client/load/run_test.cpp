#include "client/load/run.h"

#include <doctest/doctest.h>

#include <atomic>
#include <mutex>
#include <set>

#include "../fake_server.h"
#include "client/load/environment.h"
#include "client/load/search.h"
#include "client/load/selftest.h"
#include "client/load/stub_server.h"
#include "few_files.h"
#include "scripted_server.h"

namespace rivage::client::load {
namespace {

LoadPlan planFor(const std::string& url, const Mix& mix, const ArrivalPlan& arrivals) {
    Interrupt none;
    const Endpoint endpoint = *parseEndpoint(url);
    const Target target = *resolveTarget(endpoint);
    auto prepared = prepareMix(mix, {endpoint}, target, none);
    REQUIRE(prepared);
    LoadPlan plan{target, *std::move(prepared), arrivals};
    plan.warmup = std::chrono::duration<double>(0);
    plan.duration = std::chrono::duration<double>(1);
    return plan;
}

LoadResult runPlan(const LoadPlan& plan) {
    Interrupt none;
    return runLoad(plan, none);
}

Mix jobMix(Follow follow) {
    Mix mix;
    mix.entries.push_back({.name = "job", .mode = Mode::job, .sample = "x", .follow = follow});
    mix.entries.back().pollEvery = std::chrono::milliseconds(5);
    mix.entries.back().cancelAfter = std::chrono::milliseconds(5);
    return mix;
}

/// A server that takes jobs; they are over at the third question.
class JobServer : public FakeServer {
public:
    explicit JobServer(const std::string& last) : last_(last) {
        http.Get("/v1/samples/x", [](const auto&, auto& response) {
            response.set_content("grid", "application/octet-stream");
        });
        http.Post("/v1/jobs", [this](const auto&, auto& response) {
            response.status = 202;
            response.set_header("Location", "/v1/jobs/" + std::to_string(++jobs));
        });
        http.Get(R"(/v1/jobs/(\d+))", [this](const auto&, auto& response) {
            response.set_content(state(canceled || ++questions % 3 == 0), "application/json");
        });
        http.Get(R"(/v1/jobs/\d+/events)", [this](const auto&, auto& response) {
            ++streams;
            const std::string text = "retry: 1000\n\nid: 1\nevent: progress\ndata: {}\n\n";
            response.set_content(text + "id: 2\nevent: done\ndata: " + state(true) + "\n\n",
                                 "text/event-stream");
        });
        http.Get(R"(/v1/jobs/\d+/result)", [this](const auto&, auto& response) {
            ++results;
            response.set_content("the result", "text/plain");
        });
        http.Delete(R"(/v1/jobs/\d+)", [this](const auto&, auto& response) {
            ++deletes;
            canceled = true;
            response.status = 204;
        });
        start();
    }
    std::atomic<int> jobs{0}, questions{0}, streams{0}, results{0}, deletes{0};
    std::atomic<bool> canceled{false};

private:
    std::string state(bool over) const {
        const std::string now = !over ? "running" : canceled ? "canceled" : last_;
        return R"({"state":")" + now + R"(","error":{"type":"/problems/empty-grid"}})";
    }
    std::string last_;
};

ArrivalPlan closed(int concurrency) {
    return {.kind = Arrivals::closed, .concurrency = concurrency};
}

TEST_SUITE("client/load") {
    TEST_CASE("run: an open loop sends what was planned, and all of it is counted once") {
        const StubServer stub({});
        for (const int threads : {1, 2}) {
            CAPTURE(threads);
            LoadPlan plan =
                planFor(stub.url(), plainMix("/"), {.kind = Arrivals::constant, .rate = 200});
            plan.threads = threads;
            plan.verify = 1;
            const LoadResult result = runPlan(plan);
            CHECK(result.tally.planned == 200);
            CHECK(result.tally.good == 200);
            CHECK(result.tally[Measure::corrected].count() == 200);
            CHECK(result.verified + result.unverified == 200);
            CHECK(result.goodput() == doctest::Approx(200));
        }
    }

    TEST_CASE("run: the warm-up is sent and not counted") {
        const StubServer stub({});
        LoadPlan plan =
            planFor(stub.url(), plainMix("/"), {.kind = Arrivals::constant, .rate = 100});
        plan.warmup = std::chrono::duration<double>(1);
        const LoadResult result = runPlan(plan);
        CHECK(result.tally.planned == 100);
        CHECK(stub.answered() == 200);
    }

    TEST_CASE("run: a replay sends the entries that its trace names") {
        const StubServer stub({});
        Mix mix = plainMix("/a");
        mix.entries.push_back(plainMix("/b").entries[0]);
        const auto trace = parseTrace("0,/b\n0.01,/b\n0.02,/a\n5,/a\n", mix.names());
        const LoadResult result =
            runPlan(planFor(stub.url(), mix, {.kind = Arrivals::replay, .trace = *trace}));
        CHECK(result.tally.entries[0].good == 1);  // the last one is after the end
        CHECK(result.tally.entries[1].good == 2);
    }

    TEST_CASE("run: coordinated omission shows in the corrected percentiles alone") {
        const auto p90 = [](const ArrivalPlan& arrivals, std::size_t connections) {
            const StubServer stub({.stallAt = std::chrono::duration<double>(0.3),
                                   .stallFor = std::chrono::duration<double>(0.5)});
            LoadPlan plan = planFor(stub.url(), plainMix("/"), arrivals);
            plan.limits.connections = connections;
            const LoadResult result = runPlan(plan);
            CHECK(result.tally[Measure::corrected].max() > 400'000);
            return result.tally[Measure::corrected].valueAt(90);
        };
        CHECK(p90({.kind = Arrivals::constant, .rate = 100}, 1000) > 250'000);
        CHECK(p90(closed(1), 1) < 100'000);
    }

    TEST_CASE("run: latency counts from the planned send, also if the generator is late") {
        const StubServer stub({});
        const LoadPlan plan =
            planFor(stub.url(), plainMix("/"), {.kind = Arrivals::constant, .rate = 100});
        Series series;
        Verifier verifier;
        // Half of the sends are due before the generator begins.
        Generator generator(plan, 0, Clock::now() - std::chrono::milliseconds(500), series,
                            verifier);
        generator.run(false);
        const Tally& tally = generator.tally();
        CHECK(tally.good == 100);
        CHECK(tally[Measure::corrected].max() > 490'000);
        CHECK(tally[Measure::corrected].valueAt(75) > 200'000);
        CHECK(tally[Measure::asSent].valueAt(75) < 100'000);
        CHECK(tally[Measure::lag].max() > 490'000);
        CHECK(tally.late >= 49);
    }

    TEST_CASE("run: what finds no connection is not sent, and says so") {
        const StubServer stub({.stallAt = std::chrono::duration<double>(0.01),
                               .stallFor = std::chrono::duration<double>(0.5)});
        LoadPlan plan =
            planFor(stub.url(), plainMix("/"), {.kind = Arrivals::constant, .rate = 100});
        plan.limits.connections = 2;
        const LoadResult result = runPlan(plan);
        CHECK(result.tally.notSent() > 20);
        CHECK(result.tally.notSent() + result.tally.sent == result.tally.planned);
        CHECK(result.tally.judged() == result.tally.planned);
    }

    TEST_CASE("run: clients that leave are no errors") {
        const StubServer stub({.stallAt = std::chrono::duration<double>(0),
                               .stallFor = std::chrono::duration<double>(0.5)});
        Mix mix = plainMix("/");
        mix.aborts = 1;
        mix.abortAfter = std::chrono::milliseconds(20);
        const LoadResult result =
            runPlan(planFor(stub.url(), mix, {.kind = Arrivals::constant, .rate = 50}));
        CHECK(result.tally.aborted >= 20);
        CHECK(result.tally.errorRate() == 0);
    }

    TEST_CASE("run: ratios of a mix, and the heads that ask for fresh results") {
        FakeServer server;
        std::atomic<int> fresh{0};
        std::atomic<int> all{0};
        server.http.Get("/v1/samples/x", [](const auto&, auto& response) {
            response.set_content("grid", "application/octet-stream");
        });
        server.http.Post("/v1/regularize", [&](const auto& request, auto& response) {
            ++all;
            if (request.get_header_value("Cache-Control") == "no-cache") ++fresh;
            response.status = request.body == "grid" && request.has_param("alpha") ? 200 : 500;
        });
        server.start();
        Mix mix;
        mix.entries.push_back({.name = "x", .sample = "x", .options = {{"alpha", "0.02"}}});
        mix.duplicates = 0.25;
        const LoadResult result =
            runPlan(planFor(server.url(), mix, {.kind = Arrivals::constant, .rate = 400}));
        CHECK(result.tally.failed == 0);
        CHECK(fresh / static_cast<double>(all) == doctest::Approx(0.75).epsilon(0.1));
    }

    TEST_CASE("run: jobs are followed by events, by waiting and by polling") {
        for (const Follow follow : {Follow::events, Follow::wait, Follow::poll}) {
            CAPTURE(static_cast<int>(follow));
            JobServer server("succeeded");
            const LoadResult result = runPlan(planFor(server.url(), jobMix(follow), closed(1)));
            CHECK(result.tally.jobs > 0);
            CHECK(result.tally.failed == 0);
            CHECK(result.tally[Measure::jobResult].count() == result.tally.jobs);
            const bool events = follow == Follow::events;
            CHECK(result.tally[Measure::jobFirstEvent].count() >= (events ? 1 : 0));
            CHECK((result.tally.polls == 0) == events);
        }
    }

    TEST_CASE("run: jobs that fail, are left alone, or are cancelled") {
        {
            JobServer server("failed");
            const LoadResult result =
                runPlan(planFor(server.url(), jobMix(Follow::events), closed(1)));
            CHECK(result.tally.errors.count("job-failed empty-grid") == 1);
            CHECK(result.tally.good == 0);
        }
        {
            JobServer server("succeeded");
            Mix mix = jobMix(Follow::poll);
            mix.entries[0].abandoned = 1;
            const LoadResult result = runPlan(planFor(server.url(), mix, closed(1)));
            CHECK(result.tally.abandoned > 0);
            CHECK(server.questions == 0);
        }
        for (const Follow follow : {Follow::poll, Follow::wait}) {
            JobServer server("running");
            Mix mix = jobMix(follow);
            mix.entries[0].cancelled = 1;
            LoadPlan plan = planFor(server.url(), mix, closed(1));
            plan.maxRequests = 1;
            const LoadResult result = runPlan(plan);
            CHECK(result.tally.cancelled == 1);
            CHECK(server.deletes == 1);
            CHECK(result.tally[Measure::jobCancel].count() == 1);
        }
    }

    TEST_CASE("reject: jobs that say nothing we understand, however deep they are nested") {
        const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
        for (const Follow follow : {Follow::events, Follow::poll})
            for (const std::string& last :
                 {std::string("bored"), "failed\",\"deep\":" + deep + ",\"x\":\""}) {
                JobServer server(last);
                LoadPlan plan = planFor(server.url(), jobMix(follow), closed(1));
                plan.maxRequests = 1;
                CHECK(runPlan(plan).tally.errors["not-understood"] == 1);
            }
    }

    TEST_CASE("run: an interrupt ends it soon") {
        const StubServer stub({});
        LoadPlan plan = planFor(stub.url(), plainMix("/"), closed(2));
        plan.duration = std::chrono::duration<double>(60);
        Interrupt interrupt;
        std::thread later([&] {
            std::this_thread::sleep_for(std::chrono::milliseconds(300));
            interrupt.request();
        });
        const TimePoint begin = Clock::now();
        const LoadResult result = runLoad(plan, interrupt);
        later.join();
        CHECK(result.interrupted);
        CHECK(Clock::now() - begin < std::chrono::seconds(5));
        CHECK(exitOf(result, {}) == LoadExit::cancelled);
    }

    TEST_CASE("run: a closed loop does not storm a server that is gone") {
        const LoadResult result = runPlan(planFor("http://127.0.0.1:1", plainMix("/"), closed(2)));
        CHECK(result.tally.failed > 0);
        CHECK(result.tally.failed < 100);
        CHECK(exitOf(result, {}) == LoadExit::unreachable);
    }

    TEST_CASE("health: more than one late send in a hundred, and the run is invalid") {
        LoadPlan plan =
            planFor("http://127.0.0.1:1", plainMix("/"), {.kind = Arrivals::constant, .rate = 10});
        Tally tally;
        tally.sent = 1000;
        tally.late = 10;
        CHECK(judgeHealth(plan, tally, {.cpu = 0.5}).valid);
        tally.late = 11;
        const GeneratorHealth late = judgeHealth(plan, tally, {.cpu = 0.5, .loadAverage = 12.34});
        CHECK_FALSE(late.valid);
        CHECK(late.reason.find("1.1 % of the sends were late; the load average was 12.3 on ") == 0);
        LoadResult result;
        result.health = late;
        CHECK(exitOf(result, {}) == LoadExit::late);
        plan.arrivals = closed(1);
        CHECK(judgeHealth(plan, tally, {}).valid);  // it has no times to keep
    }

    TEST_CASE("health: a run without files ends at once, with code 3 and a way out") {
        // It never answers, so that each request needs a connection of its own.
        const ScriptedServer server([](const ScriptedConnection& client) {
            while (!client.readHead().empty()) {
            }
        });
        for (const ArrivalPlan& arrivals :
             {closed(50), ArrivalPlan{.kind = Arrivals::constant, .rate = 500}}) {
            for (const int left : {1, 12}) {
                CAPTURE(left);
                CAPTURE(arrivals.rate);
                LoadPlan plan = planFor(server.url(), plainMix("/"), arrivals);
                plan.duration = std::chrono::duration<double>(10);
                plan.limits.keepAlive = true;
                const FewFiles few(left);
                const TimePoint begin = Clock::now();
                const LoadResult result = runPlan(plan);
                CHECK(Clock::now() - begin < std::chrono::seconds(5));
                CHECK(exitOf(result, {}) == LoadExit::late);
                CHECK(result.health.reason.find("256 open here (RLIMIT_NOFILE)") !=
                      std::string::npos);
                CHECK(result.health.reason.find("ulimit") != std::string::npos);
            }
        }
    }

    TEST_CASE("health: as many files may be open as the user may have") {
        rlimit before{};
        getrlimit(RLIMIT_NOFILE, &before);
        rlimit files = before;
        files.rlim_cur = 256;
        REQUIRE(setrlimit(RLIMIT_NOFILE, &files) == 0);
        CHECK(prepareFiles());
        getrlimit(RLIMIT_NOFILE, &files);
        setrlimit(RLIMIT_NOFILE, &before);
        CHECK(files.rlim_cur == files.rlim_max);
    }

    TEST_CASE("reject: a Location that is no job of this server is not asked for") {
        for (const std::string& location :
             {std::string(), std::string("/v1/jobs/"), std::string("/v1/jobs/../samples"),
              std::string("/v1/jobs/1/result"), std::string("/v1/jobs/1?x=y"),
              std::string("/v1/jobs/a b"), std::string("http://127.0.0.1:1/v1/jobs/1"),
              std::string("/other/1"), "/v1/jobs/" + std::string(300, 'a')}) {
            CAPTURE(location);
            std::atomic<int> asked{0};
            FakeServer server;
            server.http.Get("/v1/samples/x", [](const auto&, auto& response) {
                response.set_content("grid", "application/octet-stream");
            });
            server.http.Post("/v1/jobs", [&](const auto&, auto& response) {
                response.status = 202;
                response.set_header("Location", location);
            });
            server.http.Get(".*", [&](const auto&, auto&) { ++asked; });
            server.start();
            LoadPlan plan = planFor(server.url(), jobMix(Follow::poll),
                                    {.kind = Arrivals::constant, .rate = 50});
            plan.duration = std::chrono::duration<double>(0.2);
            const LoadResult result = runPlan(plan);
            CHECK(result.tally.errors ==
                  std::map<std::string, std::uint64_t>{{"bad-location", 10}});
            CHECK(asked == 0);
        }
    }

    TEST_CASE("run: a Server-Timing that is no time is passed over") {
        for (const char* value : {"1e300", "inf", "nan", "-5", "9e99", "", "4000000"}) {
            CAPTURE(value);
            FakeServer server;
            server.http.Get("/v1/samples/x", [](const auto&, auto& response) {
                response.set_content("grid", "application/octet-stream");
            });
            server.http.Post("/v1/regularize", [&](const auto&, auto& response) {
                response.set_header("Server-Timing", "queue;dur=2, solve;dur=" +
                                                         std::string(value) + ", write;dur=3");
            });
            server.start();
            Mix mix;
            mix.entries.push_back({.name = "x", .sample = "x"});
            LoadPlan plan = planFor(server.url(), mix, {.kind = Arrivals::constant, .rate = 50});
            plan.duration = std::chrono::duration<double>(0.2);
            const LoadResult result = runPlan(plan);
            CHECK(result.tally[Measure::serverQueue].max() == 2000);
            CHECK(result.tally[Measure::serverCompute].max() == 3000);
        }
    }

    TEST_CASE("metrics: what is no name or no number is no column") {
        CHECK(parseMetrics("rivage_a\x1b[2J 1\nrivage_a,b 1\nrivage_\"x 1\nrivage_c NaN\n"
                           "rivage_d +Inf\nrivage_e inf\nrivage_f 1\n") ==
              MetricsSample{{"rivage_f", 1}});
        std::string many;
        for (int i = 0; i < 5000; ++i) many += "rivage_" + std::to_string(i) + " 1\n";
        CHECK(parseMetrics(many + many).size() == 1000);
    }

    TEST_CASE("metrics: sums of what the server says of itself") {
        const MetricsSample sample = parseMetrics(
            "# HELP rivage_queue_depth x\nrivage_queue_depth 3\n"
            "rivage_jobs_total{outcome=\"a\"} 2\nrivage_jobs_total{outcome=\"b c\"} 5\n"
            "rivage_job_seconds_bucket{le=\"1\"} 9\nhttp_x 1\nprocess_cpu_seconds_total 1.5\n");
        CHECK(sample == MetricsSample{{"rivage_queue_depth", 3},
                                      {"rivage_jobs_total", 7},
                                      {"process_cpu_seconds_total", 1.5}});
    }

    TEST_CASE("selftest: reads what wrk prints") {
        CHECK(readWrk("  12 requests in 2.00s\nRequests/sec:  48882.25\nTransfer/sec: 1MB\n") ==
              48882.25);
        CHECK(readWrk("") == 0);
    }
}

}  // namespace
}  // namespace rivage::client::load
