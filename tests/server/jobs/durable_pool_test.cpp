#include <doctest/doctest.h>

#include <filesystem>
#include <thread>

#include "server/jobs/disk_blob_store.h"
#include "server/jobs/job_pool.h"
#include "server/jobs/sqlite_job_store.h"
#include "tests/server/test_server.h"
#include "tests/support/temporary_folder.h"

using namespace rivage;
using namespace rivage::server;
using core::ErrorCode;
using proto::JobState;
using namespace std::chrono_literals;

namespace {

/// A store that says no as long as it is full.
class FullableStore final : public JobStore {
public:
    explicit FullableStore(JobStore& inner) : inner_(inner) {}
    core::Result<void> save(const JobRecord& record) override {
        if (full) return core::fail(ErrorCode::storageFull, "no room");
        return inner_.save(record);
    }
    core::Result<void> erase(std::span<const std::string> ids) override {
        return inner_.erase(ids);
    }
    core::Result<std::vector<JobRecord>> load() override { return inner_.load(); }

    std::atomic<bool> full{false};

private:
    JobStore& inner_;
};

/// A pool over one state folder; a new one is the next process.
struct Process {
    test::Gate gate;
    std::unique_ptr<BlobStore> blobs;
    std::unique_ptr<JobStore> jobs;
    std::unique_ptr<FullableStore> store;
    std::unique_ptr<CrashBoard> crashes;
    std::unique_ptr<JobPool> pool;

    explicit Process(const std::string& folder, PoolSettings settings = {.workers = 1}) {
        blobs = openDiskBlobStore(folder).value();
        jobs = openSqliteJobStore(folder).value();
        store = std::make_unique<FullableStore>(*jobs);
        crashes = CrashBoard::open(folder + "/crashes", 1h).value();
        crashes->recover();
        pool = std::make_unique<JobPool>(settings, test::fakeEngine(gate), JobPool::Observer(),
                                         Storage{blobs.get(), store.get(), crashes.get()});
    }

    core::Result<std::shared_ptr<Job>> trySubmit(const std::string& text, bool durable = true) {
        JobRequest request;
        const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
        request.input.assign(bytes, bytes + text.size());
        request.durable = durable;
        request.idempotencyKey = "key of " + text;
        return pool->submit(*pool->admit(), std::move(request));
    }
    std::shared_ptr<Job> submit(const std::string& text, bool durable = true) {
        auto job = trySubmit(text, durable);
        REQUIRE(job);
        return *job;
    }
    std::shared_ptr<Job> find(const std::string& id) {
        auto job = pool->find("", id);
        REQUIRE(job);
        return *job;
    }
};

std::size_t filesIn(const std::string& folder) {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        count += entry.is_regular_file();
    return count;
}

}  // namespace

TEST_SUITE_BEGIN("server/jobs");

TEST_CASE("JobPool: the next process finds durable jobs with their results, and no others") {
    const test::TemporaryFolder folder;
    std::string kept;
    std::string lost;
    {
        Process first(folder.path());
        const auto durable = first.submit("ok");
        const auto fleeting = first.submit("ok 2", false);
        REQUIRE(durable->waitEnded(5s));
        REQUIRE(fleeting->waitEnded(5s));
        kept = durable->id();
        lost = fleeting->id();
    }
    Process second(folder.path());
    CHECK_FALSE(second.pool->find("", lost));
    const auto job = second.find(kept);
    CHECK(job->state() == JobState::succeeded);
    const auto result = second.pool->result(*job);
    REQUIRE(result);
    CHECK((*result)->size() == std::string("asset of ok").size());
    CHECK(job->view().report.is_object());

    const auto again = second.submit("ok");
    REQUIRE(again->waitEnded(5s));
    CHECK(again->snapshot().reuse == Reuse::hit);
    CHECK(second.gate.started == 0);
    CHECK(second.pool->idempotency().claim("", "key of ok")->job->id() == job->id());
}

TEST_CASE("JobPool: what had not ended runs again in the next process, and ends once") {
    const test::TemporaryFolder folder;
    std::vector<std::string> ids;
    {
        Process first(folder.path());
        for (const char* grid : {"slow", "slow 2", "slow"}) ids.push_back(first.submit(grid)->id());
        for (int i = 0; i < 5000 && first.gate.running == 0; ++i) std::this_thread::sleep_for(1ms);
        first.pool->beginDraining();
        first.pool->stopAll();
    }
    Process second(folder.path());
    second.gate.open = true;
    for (const std::string& id : ids) {
        const auto job = second.find(id);
        REQUIRE(job->waitEnded(5s));
        CHECK(job->state() == JobState::succeeded);
    }
    CHECK(second.gate.started == 2);
    CHECK(second.find(ids[0])->snapshot().view.attempt == 2);
}

TEST_CASE("JobPool: a job that turns out to be for later is kept from then on") {
    const test::TemporaryFolder folder;
    std::string id;
    {
        Process first(folder.path());
        const auto job = first.submit("slow", false);
        id = job->id();
        REQUIRE(first.pool->keep(job));
    }
    Process second(folder.path());
    second.gate.open = true;
    REQUIRE(second.find(id)->waitEnded(5s));
    CHECK(second.find(id)->state() == JobState::succeeded);
}

TEST_CASE("JobPool: an input that was running at two crashes is in quarantine") {
    const test::TemporaryFolder folder;
    std::string id;
    const auto crash = [&](int count) {
        Process process(folder.path());
        if (count == 0) id = process.submit("slow")->id();
        for (int i = 0; i < 5000 && process.gate.running == 0; ++i)
            std::this_thread::sleep_for(1ms);
        REQUIRE(process.gate.running == 1);
        // As if the process ended here: what it leaves behind is what a killed one leaves.
        const std::string board = folder.path() + "/crashes";
        std::filesystem::copy_file(board, board + ".dead");
        process.pool->stopAll();
        process.pool.reset();
        std::filesystem::rename(board + ".dead", board);
    };
    crash(0);
    crash(1);
    Process third(folder.path());
    const auto job = third.find(id);
    REQUIRE(job->waitEnded(5s));
    CHECK(job->snapshot().error->code == ErrorCode::poison);
    CHECK(third.trySubmit("slow").error().code == ErrorCode::poison);
    CHECK(third.trySubmit("slow", false).error().code == ErrorCode::poison);
    CHECK(third.submit("ok")->waitEnded(5s));
    CHECK(third.gate.started == 1);
    CHECK(third.pool->stats().poisoned == 1);
}

TEST_CASE("JobPool: a suspect runs alone") {
    const test::TemporaryFolder folder;
    {
        const auto board = CrashBoard::open(folder.path() + "/crashes", 1h).value();
        const std::string text = "slow suspect";
        board->begin(0, sha256(std::as_bytes(std::span(text))).hex);
    }
    Process process(folder.path(), {.workers = 2});
    const auto innocent = process.submit("slow");
    for (int i = 0; i < 5000 && process.gate.running == 0; ++i) std::this_thread::sleep_for(1ms);
    const auto suspect = process.submit("slow suspect");
    const auto other = process.submit("ok");
    CHECK_FALSE(other->waitEnded(100ms));
    CHECK(process.gate.running == 1);
    process.gate.open = true;
    for (const auto& job : {innocent, suspect, other}) REQUIRE(job->waitEnded(5s));
    CHECK(process.crashes->crashes(suspect->facts().inputSha256) == 0);
}

TEST_CASE("JobPool: without room a durable job is refused; one that ended is saved later") {
    const test::TemporaryFolder folder;
    std::string id;
    {
        Process process(folder.path(), {.workers = 2});
        const auto job = process.submit("slow");
        id = job->id();
        process.store->full = true;
        const auto refused = process.trySubmit("ok");
        REQUIRE_FALSE(refused);
        CHECK(refused.error().code == ErrorCode::storageFull);
        CHECK(process.submit("ok 2", false)->waitEnded(5s));
        process.gate.open = true;
        REQUIRE(job->waitEnded(5s));
        process.store->full = false;
        std::this_thread::sleep_for(200ms);
        CHECK(process.pool->list({}).size() == 2);
    }
    Process second(folder.path());
    CHECK(second.find(id)->state() == JobState::succeeded);
    CHECK(second.pool->list({}).size() == 1);
    CHECK(second.gate.started == 0);
}

TEST_CASE("JobPool: what nobody needs any more leaves the disk") {
    const test::TemporaryFolder folder;
    Process process(folder.path());
    const auto job = process.submit("ok");
    REQUIRE(job->waitEnded(5s));
    CHECK(filesIn(folder.path() + "/blobs") == 2);
    process.pool->forget(*job);
    for (int i = 0; i < 500 && filesIn(folder.path() + "/blobs") > 1; ++i)
        std::this_thread::sleep_for(10ms);
    // The result is held by the test's job; the grid is not.
    CHECK(filesIn(folder.path() + "/blobs") == 1);
    CHECK(process.jobs->load()->empty());
}

TEST_SUITE_END();
