#include "server/jobs/job_index.h"

#include <doctest/doctest.h>

using namespace rivage;
using namespace rivage::server;
using core::ErrorCode;
using proto::JobState;
using namespace std::chrono_literals;

namespace {

std::shared_ptr<Job> makeJob(const std::string& id, const std::string& owner = {}) {
    JobFacts facts;
    facts.id = id;
    facts.owner = owner;
    return std::make_shared<Job>(std::move(facts), Clock::now() + 10s);
}

/// @param fill  of its result: the same fill and size are the same bytes
std::shared_ptr<Job> endedJob(JobIndex& store, const std::string& id, std::size_t bytes,
                              const std::string& owner = {}, char fill = 0) {
    const auto job = makeJob(id, owner);
    store.add(job);
    const auto value = static_cast<std::byte>(fill ? fill : id[0]);
    auto blob = MemoryBlobStore().put(std::vector<std::byte>(bytes, value));
    REQUIRE(job->end({.result = std::make_shared<JobResult>(*std::move(blob), "t", "x")}));
    store.ended(job);
    return job;
}

}  // namespace

TEST_SUITE_BEGIN("server/jobs");

TEST_CASE("JobIndex: a job is found until its time is over, then it has expired") {
    JobIndex store({.resultTtl = 60s});
    const auto job = endedJob(store, "a", 10);
    CHECK(job->snapshot().view.expiresAt);
    store.sweep(Clock::now() + 59s);
    CHECK(store.find("", "a"));
    store.sweep(Clock::now() + 61s);
    CHECK(store.find("", "a").error().code == ErrorCode::expired);
    CHECK(store.find("", "b").error().code == ErrorCode::notFound);
}

TEST_CASE("JobIndex: the oldest results make room, their jobs stay") {
    JobIndex store({.resultBytes = 25});
    const auto first = endedJob(store, "a", 10);
    const auto second = endedJob(store, "b", 10);
    const auto third = endedJob(store, "c", 10);
    CHECK_FALSE(first->snapshot().view.hasResult);
    CHECK(second->snapshot().result);
    CHECK(third->snapshot().result);
    CHECK(store.find("", "a"));
    const auto huge = endedJob(store, "d", 1000);
    CHECK_FALSE(third->snapshot().result);
    CHECK(huge->snapshot().result);
}

TEST_CASE("JobIndex: identical jobs share the room of their result") {
    JobIndex store({.resultBytes = 25});
    const auto first = endedJob(store, "a", 20, "", 'x');
    const auto second = endedJob(store, "b", 20, "", 'x');
    CHECK(first->snapshot().result);
    const auto third = endedJob(store, "c", 20);
    CHECK_FALSE(first->snapshot().result);
    CHECK_FALSE(second->snapshot().result);
    CHECK(store.takeChanges().changed.size() == 2);
    CHECK(store.needed() == std::set<std::string>{third->record().resultSha256});
}

TEST_CASE("JobIndex: the jobs of one owner are not there for others, not even when expired") {
    JobIndex store({.resultTtl = 60s});
    endedJob(store, "a", 1, "ann");
    endedJob(store, "b", 1, "bob");
    CHECK(store.find("ann", "a"));
    CHECK(store.find("bob", "a").error().code == ErrorCode::notFound);
    CHECK(store.find("", "a").error().code == ErrorCode::notFound);
    CHECK(store.list({.owner = "bob"}).size() == 1);
    store.sweep(Clock::now() + 61s);
    CHECK(store.find("ann", "a").error().code == ErrorCode::expired);
    CHECK(store.find("bob", "a").error().code == ErrorCode::notFound);
    CHECK(store.takeChanges().gone == std::vector<std::string>{"a", "b"});
}

TEST_CASE("JobIndex: more jobs than the limit: the oldest expire") {
    JobIndex store({.jobs = 2});
    for (const char* id : {"a", "b", "c"}) endedJob(store, id, 1);
    CHECK(store.find("", "a").error().code == ErrorCode::expired);
    CHECK(store.list({}).size() == 2);
}

TEST_CASE("JobIndex: a forgotten job is unknown, and its bytes are free again") {
    JobIndex store({.resultBytes = 25});
    const auto first = endedJob(store, "a", 20);
    store.forget("a");
    CHECK(store.find("", "a").error().code == ErrorCode::notFound);
    const auto second = endedJob(store, "b", 20);
    const auto third = endedJob(store, "c", 5);
    CHECK(second->snapshot().result);
}

TEST_CASE("JobIndex: the list is newest first, by state, in pages") {
    JobIndex store(StoreLimits{});
    for (const char* id : {"a", "b", "c"}) endedJob(store, id, 1);
    store.add(makeJob("d"));
    const auto ids = [&](const JobQuery& query) {
        std::string text;
        for (const auto& job : store.list(query)) text += job->id();
        return text;
    };
    CHECK(ids({}) == "dcba");
    CHECK(ids({.limit = 2}) == "dc");
    CHECK(ids({.after = "c"}) == "ba");
    CHECK(ids({.state = JobState::queued}) == "d");
    CHECK(ids({.state = JobState::failed}).empty());
}

TEST_SUITE_END();
