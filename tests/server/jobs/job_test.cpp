#include "server/jobs/job.h"

#include <doctest/doctest.h>

using namespace rivage;
using namespace rivage::server;
using core::ErrorCode;
using core::Stage;
using proto::JobState;
using namespace std::chrono_literals;

namespace {

Job makeJob(std::chrono::milliseconds time = 10s) {
    JobRequest request;
    request.input.resize(7);
    return {"id", std::move(request), Clock::now() + time};
}

core::Artifact artifact() { return {{3, std::byte{1}}, "model/obj", "obj", {}}; }

}  // namespace

TEST_SUITE_BEGIN("server/jobs");

TEST_CASE("Job: queued, running, succeeded, with all that belongs to it") {
    Job job = makeJob();
    CHECK(job.state() == JobState::queued);
    REQUIRE(job.start());
    CHECK(job.input().size() == 7);
    job.report(Stage::parse, 0);
    job.report(Stage::solve, 0.5);
    const JobSnapshot running = job.snapshot();
    CHECK(running.view.stage == Stage::solve);
    CHECK(running.view.progress > 0.2);
    CHECK(running.view.attempt == 1);
    job.report(Stage::parse, 1);
    CHECK(job.snapshot().view.progress == running.view.progress);

    job.finish(artifact());
    const JobSnapshot done = job.snapshot();
    CHECK(done.view.state == JobState::succeeded);
    CHECK(done.view.progress == 1);
    CHECK(done.view.hasResult);
    CHECK(done.result->fileName == "rivage.obj");
    CHECK(done.result->etag.size() == 66);
    CHECK(done.inputBytes == 7);
    CHECK(done.view.report.is_object());
    CHECK(job.input().empty());
}

TEST_CASE("Job: the end wakes nobody before it is announced") {
    Job job = makeJob();
    REQUIRE(job.start());
    job.finish(artifact());
    CHECK_FALSE(job.waitEnded(1ms));
    job.announce();
    CHECK(job.waitEnded(0ms));
}

TEST_CASE("Job: cancelled while it waits, it ends at once and never starts") {
    Job job = makeJob();
    CHECK(job.cancel());
    CHECK(job.state() == JobState::canceled);
    CHECK_FALSE(job.start());
    CHECK_FALSE(job.cancel());
    CHECK(job.snapshot().error->code == ErrorCode::cancelled);
}

TEST_CASE("Job: cancelled while it runs, cancellation wins over success") {
    Job job = makeJob();
    REQUIRE(job.start());
    CHECK_FALSE(job.cancel());
    CHECK(job.stopRequested());
    CHECK(job.stopReason() == ErrorCode::cancelled);
    job.finish(artifact());
    CHECK(job.state() == JobState::canceled);
    CHECK_FALSE(job.snapshot().result);
}

TEST_CASE("Job: the deadline stops it while it runs and ends it while it waits") {
    Job running = makeJob(0ms);
    REQUIRE(running.start());
    CHECK(running.stopRequested());
    CHECK(running.stopReason() == ErrorCode::timedOut);
    CHECK_FALSE(running.expire(Clock::now()));

    Job waiting = makeJob(1ms);
    CHECK_FALSE(waiting.expire(Clock::now() - 1s));
    CHECK(waiting.expire(Clock::now() + 1s));
    CHECK(waiting.state() == JobState::failed);
    CHECK(waiting.snapshot().view.error->type.status == 504);
}

TEST_CASE("Job: the time of each stage is its own") {
    Job job = makeJob();
    REQUIRE(job.start());
    job.report(Stage::parse, 0);
    job.report(Stage::mesh, 0);
    const auto until = Clock::now() + 5ms;
    while (Clock::now() < until) {
    }
    job.report(Stage::write, 0);
    job.finish(artifact());
    const JobTimes times = job.snapshot().times;
    CHECK(times.stages[static_cast<std::size_t>(Stage::mesh)] >= 5);
    CHECK(times.stages[static_cast<std::size_t>(Stage::solve)] == 0);
}

TEST_SUITE_END();
