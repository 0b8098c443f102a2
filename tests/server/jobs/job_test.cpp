#include "server/jobs/job.h"

#include <doctest/doctest.h>

#include <memory>

using namespace rivage;
using namespace rivage::server;
using core::ErrorCode;
using core::Stage;
using proto::JobState;
using namespace std::chrono_literals;

namespace {

std::unique_ptr<Job> makeJob() {
    JobFacts facts;
    facts.id = "id";
    facts.inputBytes = 7;
    facts.options = R"({"alpha":0.5})";
    return std::make_unique<Job>(std::move(facts), Clock::now() + 10s);
}

RunOutcome success() {
    MemoryBlobStore store;
    auto facts = std::make_shared<RunFacts>();
    facts->report = R"({"input":{}})";
    facts->stages[0] = 5;
    return {
        .result = std::make_shared<JobResult>(*store.put({3, std::byte{1}}), "model/obj", "obj"),
        .facts = facts};
}

RunOutcome failure(ErrorCode code) { return {.error = core::Error{code, "why"}}; }

}  // namespace

TEST_SUITE_BEGIN("server/jobs");

TEST_CASE("Job: queued, running, succeeded, with all that belongs to it") {
    const auto job = makeJob();
    CHECK(job->state() == JobState::queued);
    REQUIRE(job->start());
    job->advance(Stage::parse, 0.1);
    job->advance(Stage::solve, 0.5);
    job->advance(Stage::parse, 0.2);
    const JobSnapshot running = job->snapshot();
    CHECK(running.view.progress == 0.5);
    CHECK(running.view.attempt == 1);

    CHECK(proto::toJson(running.view)["energy"].is_null());
    job->advance(proto::SolverStep{4, 2.5});
    CHECK(proto::toJson(job->view())["step"] == 4);
    CHECK(proto::toJson(job->view())["energy"] == 2.5);

    REQUIRE(job->end(success(), std::chrono::seconds(60)));
    CHECK(proto::toJson(job->view())["energy"].is_null());
    CHECK(*job->view().expiresAt - *job->view().finished == std::chrono::seconds(60));
    const JobSnapshot done = job->snapshot();
    CHECK(done.view.state == JobState::succeeded);
    CHECK(done.view.progress == 1);
    CHECK(done.view.hasResult);
    CHECK(done.result->etag.size() == 66);
    CHECK(done.times.stages[0] == 5);
    CHECK(job->view().report.is_object());
    CHECK(job->view().options["alpha"] == 0.5);
}

TEST_CASE("Job: the first end counts, whatever comes later") {
    const auto job = makeJob();
    REQUIRE(job->start());
    CHECK(job->end(failure(ErrorCode::cancelled)));
    CHECK(job->state() == JobState::canceled);
    CHECK_FALSE(job->end(success()));
    CHECK_FALSE(job->start());
    CHECK(job->state() == JobState::canceled);
    CHECK_FALSE(job->snapshot().result);
    CHECK(job->snapshot().view.error->instance == "/v1/jobs/id");
}

TEST_CASE("Job: the end wakes nobody before it is announced") {
    const auto job = makeJob();
    REQUIRE(job->end(success()));
    CHECK_FALSE(job->waitEnded(1ms));
    job->announce();
    CHECK(job->waitEnded(0ms));
}

TEST_CASE("Job: only the last waiter of a job that nobody was promised cancels it") {
    const auto job = makeJob();
    job->addWaiter();
    job->addWaiter();
    CHECK_FALSE(job->removeWaiter());
    CHECK(job->removeWaiter());
    job->makeDurable();
    job->addWaiter();
    CHECK_FALSE(job->removeWaiter());
}

TEST_CASE("Job: events have increasing ids and are replayed from where a client was") {
    const auto job = makeJob();
    job->advanceInQueue(1);
    REQUIRE(job->start());
    for (const Stage stage : {Stage::parse, Stage::surface, Stage::solve}) job->advance(stage, 0.1);
    const auto all = job->waitEvents(0, 0ms);
    REQUIRE(all.size() == 5);
    for (std::size_t i = 0; i < all.size(); ++i) CHECK(all[i].id == i + 1);
    CHECK(all[0].data ==
          R"({"state":"queued","stage":null,"progress":0.0,"step":null,"energy":null,)"
          R"("queue_position":1})");
    CHECK(job->waitEvents(3, 0ms).front().id == 4);
    CHECK(job->waitEvents(5, 1ms).empty());
    for (int i = 0; i < 300; ++i) job->advance(i % 2 ? Stage::mesh : Stage::write, 0.2);
    CHECK(job->waitEvents(0, 0ms).size() == 256);
    CHECK(job->waitEvents(0, 0ms).back().id == 305);
}

TEST_CASE("Job: a preview is there while it runs") {
    const auto job = makeJob();
    REQUIRE(job->start());
    CHECK_FALSE(job->preview());
    job->offer({4, 2.5, success().result});
    CHECK(job->preview()->step == 4);
    CHECK(job->waitEvents(1, 0ms).front().name == "preview");
    REQUIRE(job->end(success()));
    CHECK_FALSE(job->preview());
}

TEST_CASE("Job: its record gives it back, ended or queued again") {
    const auto job = makeJob();
    REQUIRE(job->start());
    const Job again(job->record(), Clock::now() + 10s);
    CHECK(again.state() == JobState::queued);
    CHECK(again.snapshot().view.attempt == 1);
    CHECK_FALSE(again.announced());

    REQUIRE(job->end(success()));
    const Job ended(job->record(), Clock::now());
    CHECK(ended.announced());
    CHECK(ended.state() == JobState::succeeded);
    CHECK(ended.snapshot().view.hasResult);
    CHECK(ended.view().report.is_object());
    CHECK(ended.record().resultSha256 == job->record().resultSha256);
    CHECK(ended.record().resultBytes == 3);
}

TEST_SUITE_END();
