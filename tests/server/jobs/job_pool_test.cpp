#include "server/jobs/job_pool.h"

#include <doctest/doctest.h>

#include <thread>

#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::server;
using core::ErrorCode;
using proto::JobState;
using namespace std::chrono_literals;

namespace {

JobRequest request(const std::string& text) {
    JobRequest request;
    const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
    request.input.assign(bytes, bytes + text.size());
    return request;
}

struct Fixture {
    test::Gate gate;
    std::atomic<int> observed{0};
    JobPool pool;

    explicit Fixture(PoolSettings settings = {.workers = 2, .queueLimit = 4})
        : pool(settings, test::fakeEngine(gate),
               [this](const JobFacts&, const JobSnapshot&) { ++observed; }) {}

    std::shared_ptr<Job> submit(const std::string& text) {
        auto ticket = pool.admit();
        REQUIRE(ticket);
        auto job = pool.submit(*std::move(ticket), request(text));
        REQUIRE(job);
        return *job;
    }
    void waitStarted(int count) {
        for (int i = 0; i < 5000 && gate.started < count; ++i) std::this_thread::sleep_for(1ms);
        REQUIRE(gate.started == count);
    }
    void waitIdle() {
        for (int i = 0; i < 5000 && !pool.idle(); ++i) std::this_thread::sleep_for(1ms);
        REQUIRE(pool.idle());
    }
};

}  // namespace

TEST_SUITE_BEGIN("server/jobs");

TEST_CASE("JobPool: a job runs and is found with its result") {
    Fixture fixture;
    const auto job = fixture.submit("ok");
    REQUIRE(job->waitEnded(5s));
    CHECK(job->snapshot().result->size() == std::string("asset of ok").size());
    REQUIRE(fixture.pool.find("", job->id()));
    CHECK(*fixture.pool.find("", job->id()) == job);
    CHECK(fixture.observed == 1);
    fixture.waitIdle();
}

TEST_CASE("JobPool: workers and queue full: busy at once, free again when a job ends") {
    Fixture fixture;
    std::vector<std::shared_ptr<Job>> jobs;
    for (int i = 0; i < 6; ++i) jobs.push_back(fixture.submit("slow" + std::to_string(i)));
    const auto refused = fixture.pool.admit();
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ErrorCode::busy);
    CHECK(refused.error().limit == 4);
    CHECK(refused.error().setting == "--queue-limit");
    fixture.gate.open = true;
    for (const auto& job : jobs) REQUIRE(job->waitEnded(5s));
    fixture.waitIdle();
    CHECK(fixture.pool.admit());
    CHECK(fixture.pool.stats().rejectedFull == 1);
    CHECK(fixture.pool.stats().jobs[static_cast<std::size_t>(JobState::succeeded)] == 6);
}

TEST_CASE("JobPool: a ticket that is dropped gives its place back") {
    Fixture fixture({.workers = 1, .queueLimit = 0});
    for (int i = 0; i < 10; ++i) {
        const auto ticket = fixture.pool.admit();
        CHECK(ticket);
        CHECK_FALSE(fixture.pool.admit());
    }
    CHECK(fixture.pool.idle());
}

TEST_CASE("JobPool: positions in the queue count from the next") {
    Fixture fixture({.workers = 1, .queueLimit = 4});
    const auto running = fixture.submit("slow");
    fixture.waitStarted(1);
    const auto next = fixture.submit("slow 2");
    const auto last = fixture.submit("slow 3");
    CHECK_FALSE(fixture.pool.view(*running).queuePosition);
    CHECK(fixture.pool.view(*next).queuePosition == 0);
    CHECK(fixture.pool.view(*last).queuePosition == 1);
}

TEST_CASE("JobPool: cancelling frees the worker, and takes a waiting job out of the queue") {
    Fixture fixture({.workers = 1, .queueLimit = 4});
    const auto running = fixture.submit("slow");
    fixture.waitStarted(1);
    const auto waiting = fixture.submit("slow 2");
    fixture.pool.cancel(waiting);
    CHECK(waiting->waitEnded(0ms));
    const auto before = Clock::now();
    fixture.pool.cancel(running);
    REQUIRE(running->waitEnded(5s));
    CHECK(running->state() == JobState::canceled);
    while (fixture.gate.running > 0) std::this_thread::sleep_for(1ms);
    CHECK(Clock::now() - before < 250ms);
    REQUIRE(fixture.submit("ok")->waitEnded(5s));
    CHECK(fixture.gate.started == 2);
    CHECK(fixture.observed == 3);
}

TEST_CASE("JobPool: a job whose deadline passes in the queue never starts") {
    Fixture fixture({.workers = 1, .queueLimit = 4});
    const auto running = fixture.submit("slow");
    fixture.waitStarted(1);
    auto late = request("ok");
    late.options.run.deadlineMs = 20;
    const auto job = *fixture.pool.submit(*fixture.pool.admit(), std::move(late));
    REQUIRE(job->waitEnded(5s));
    CHECK(job->snapshot().error->code == ErrorCode::timedOut);
    CHECK(fixture.gate.started == 1);
    CHECK(fixture.pool.stats().timedOut == 1);
}

TEST_CASE("JobPool: the deadline stops a job that runs") {
    Fixture fixture({.workers = 1, .queueLimit = 4, .deadline = 50ms});
    const auto job = fixture.submit("slow");
    REQUIRE(job->waitEnded(5s));
    CHECK(job->state() == JobState::failed);
    CHECK(job->snapshot().error->code == ErrorCode::timedOut);
}

TEST_CASE("reject: a deadline above the server's") {
    Fixture fixture({.workers = 1, .queueLimit = 4, .deadline = 50ms});
    auto late = request("ok");
    late.options.run.deadlineMs = 51;
    const auto job = fixture.pool.submit(*fixture.pool.admit(), std::move(late));
    REQUIRE_FALSE(job);
    CHECK(job.error().code == ErrorCode::invalidOption);
    CHECK(job.error().limit == 50);
    fixture.waitIdle();
}

TEST_CASE("JobPool: what the engine throws fails the job, not the worker") {
    Fixture fixture({.workers = 1, .queueLimit = 4});
    const auto thrown = fixture.submit("throw");
    REQUIRE(thrown->waitEnded(5s));
    CHECK(thrown->snapshot().error->code == ErrorCode::internal);
    CHECK(thrown->snapshot().error->message.find("secret") == std::string::npos);
    const auto memory = fixture.submit("memory");
    REQUIRE(memory->waitEnded(5s));
    CHECK(memory->snapshot().error->code == ErrorCode::memoryBudget);
    CHECK(fixture.submit("ok")->waitEnded(5s));
}

TEST_CASE("JobPool: draining admits nothing and ends what was accepted") {
    Fixture fixture({.workers = 1, .queueLimit = 4});
    const auto running = fixture.submit("slow");
    const auto waiting = fixture.submit("ok");
    fixture.pool.beginDraining();
    CHECK(fixture.pool.admit().error().code == ErrorCode::draining);
    fixture.gate.open = true;
    fixture.waitIdle();
    CHECK(running->state() == JobState::succeeded);
    CHECK(waiting->state() == JobState::succeeded);
}

TEST_CASE("JobPool: destroyed with jobs running and waiting, it ends soon and clean") {
    std::vector<std::shared_ptr<Job>> jobs;
    {
        Fixture fixture;
        for (int i = 0; i < 6; ++i) jobs.push_back(fixture.submit("slow" + std::to_string(i)));
    }
    for (const auto& job : jobs) CHECK(job->snapshot().error->code == ErrorCode::draining);
}

TEST_CASE("JobPool: inspections are neither listed nor found") {
    Fixture fixture;
    auto look = request("ok");
    look.kind = JobKind::inspect;
    const auto job = *fixture.pool.submit(*fixture.pool.admit(), std::move(look));
    REQUIRE(job->waitEnded(5s));
    CHECK(job->snapshot().result->mediaType == "application/json");
    CHECK_FALSE(fixture.pool.find("", job->id()));
    CHECK(fixture.pool.list({}).empty());
}

TEST_CASE("JobPool: submitted, cancelled and listed from many threads, every job ends once") {
    Fixture fixture({.workers = 2, .queueLimit = 16});
    std::atomic<int> accepted{0};
    std::vector<std::thread> threads;
    for (int t = 0; t < 8; ++t)
        threads.emplace_back([&, t] {
            for (int i = 0; i < 50; ++i) {
                auto ticket = fixture.pool.admit();
                if (!ticket) continue;
                const std::string grid = "ok" + std::to_string(i % 7);
                const auto job = fixture.pool.submit(*std::move(ticket), request(grid));
                ++accepted;
                if ((i + t) % 3 == 0) fixture.pool.cancel(*job);
                (void)fixture.pool.list({});
                (void)fixture.pool.view(**job);
            }
        });
    for (std::thread& thread : threads) thread.join();
    fixture.waitIdle();
    CHECK(fixture.observed == accepted);
    const PoolStats stats = fixture.pool.stats();
    CHECK(stats.jobs[2] + stats.jobs[3] + stats.jobs[4] ==
          static_cast<std::uint64_t>(accepted.load()));
}

TEST_CASE("JobPool: identical jobs at once are run once, later ones not at all") {
    Fixture fixture({.workers = 2, .queueLimit = 4});
    std::vector<std::shared_ptr<Job>> jobs;
    for (int i = 0; i < 100; ++i) jobs.push_back(fixture.submit("slow"));
    fixture.gate.open = true;
    for (const auto& job : jobs) REQUIRE(job->waitEnded(5s));
    jobs.push_back(fixture.submit("slow"));
    CHECK(fixture.gate.started == 1);
    CHECK(jobs[0]->snapshot().reuse == Reuse::none);
    CHECK(jobs[99]->snapshot().reuse == Reuse::collapsed);
    CHECK(jobs[100]->snapshot().reuse == Reuse::hit);
    for (const auto& job : jobs) CHECK(job->snapshot().result == jobs[0]->snapshot().result);
    CHECK(fixture.pool.stats().coalesced == 99);
    CHECK(fixture.pool.stats().cacheHits == 1);
    CHECK(fixture.observed == 101);
}

TEST_CASE("JobPool: another grid, other options, another owner or no-cache is another run") {
    Fixture fixture;
    REQUIRE(fixture.submit("ok")->waitEnded(5s));
    auto other = request("ok");
    other.options.conversion.output.voxelSize = 3;
    auto foreign = request("ok");
    foreign.owner = "bob";
    auto fresh = request("ok");
    fresh.fresh = true;
    for (auto& next : {other, foreign, fresh}) {
        const auto job = *fixture.pool.submit(*fixture.pool.admit(), next);
        REQUIRE(job->waitEnded(5s));
        CHECK(job->snapshot().reuse == (next.fresh ? Reuse::bypass : Reuse::none));
        fixture.waitIdle();
    }
    CHECK(fixture.gate.started == 4);
}

TEST_CASE("JobPool: a run goes on as long as one of its jobs is wanted") {
    Fixture fixture({.workers = 1, .queueLimit = 4});
    const auto first = fixture.submit("slow");
    const auto second = fixture.submit("slow");
    fixture.waitStarted(1);
    fixture.pool.cancel(first);
    CHECK(first->state() == JobState::canceled);
    CHECK(second->state() == JobState::running);
    CHECK(fixture.gate.running == 1);
    fixture.pool.cancel(second);
    fixture.waitIdle();
    const auto third = fixture.submit("slow");
    fixture.waitStarted(2);
    fixture.gate.open = true;
    REQUIRE(third->waitEnded(5s));
    CHECK(third->state() == JobState::succeeded);
}

TEST_CASE("JobPool: a forgotten result is made again; a failure is not kept") {
    Fixture fixture;
    const auto job = fixture.submit("ok");
    REQUIRE(job->waitEnded(5s));
    fixture.pool.forget(*job);
    REQUIRE(fixture.submit("ok")->waitEnded(5s));
    CHECK(fixture.gate.started == 2);
    for (int i = 0; i < 2; ++i) {
        REQUIRE(fixture.submit("bad")->waitEnded(5s));
        fixture.waitIdle();
    }
    CHECK(fixture.gate.started == 4);
}

TEST_CASE("reject: more jobs that have not ended than are kept") {
    Fixture fixture({.workers = 1, .queueLimit = 4, .store = {.jobs = 3}});
    for (int i = 0; i < 3; ++i) fixture.submit("slow");
    const auto refused = fixture.pool.submit(*fixture.pool.admit(), request("slow"));
    REQUIRE_FALSE(refused);
    CHECK(refused.error().setting == "--kept-jobs");
}

TEST_SUITE_END();
