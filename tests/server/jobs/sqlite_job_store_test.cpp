#include "server/jobs/sqlite_job_store.h"

#include <doctest/doctest.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <string>
#include <thread>

#include "proto/problem.h"
#include "tests/support/temporary_folder.h"

using namespace rivage;
using namespace rivage::server;
using namespace std::chrono_literals;
using core::ErrorCode;
using proto::JobState;

namespace {

std::unique_ptr<JobStore> openStore(const std::string& folder) {
    auto store = openSqliteJobStore(folder);
    REQUIRE_MESSAGE(store, (store ? "" : store.error().message));
    return *std::move(store);
}

std::vector<JobRecord> loaded(JobStore& store) {
    const auto records = store.load();
    REQUIRE(records);
    return *records;
}

JobRecord fullRecord() {
    const proto::WallTime time(1'790'000'000'123ms);
    JobRecord record{.id = "0197-b", .owner = "anna", .idempotencyKey = "k'\"; DROP"};
    record.key = "key";
    record.options = R"({"alpha":0.1})";
    record.name = std::string("n\0ul \xc3\xa9", 7);
    record.requestId = "r";
    record.traceparent = "00-1";
    record.inputSha256 = "ab";
    record.inputBytes = 1ULL << 40;
    record.state = JobState::failed;
    record.stage = "solve";
    record.resultBytes = 77;
    record.attempt = 2;
    record.created = time;
    record.started = time + 1ms;
    record.finished = time + 2ms;
    record.expires = time + 3ms;
    record.resultSha256 = "cd";
    record.mediaType = "model/gltf-binary";
    record.extension = "glb";
    record.report = "{}";
    record.error = core::Error{ErrorCode::tooLarge, "much", "/grid", 5, 1ULL << 63, "--max"};
    return record;
}

void checkSame(const JobRecord& a, const JobRecord& b) {
    CHECK(a.id == b.id);
    CHECK(a.owner == b.owner);
    CHECK(a.idempotencyKey == b.idempotencyKey);
    CHECK(a.key == b.key);
    CHECK(a.options == b.options);
    CHECK(a.name == b.name);
    CHECK(a.requestId == b.requestId);
    CHECK(a.traceparent == b.traceparent);
    CHECK(a.inputSha256 == b.inputSha256);
    CHECK(a.inputBytes == b.inputBytes);
    CHECK(a.state == b.state);
    CHECK(a.attempt == b.attempt);
    CHECK(a.created == b.created);
    CHECK(a.started == b.started);
    CHECK(a.finished == b.finished);
    CHECK(a.expires == b.expires);
    CHECK(a.stage == b.stage);
    CHECK(a.resultSha256 == b.resultSha256);
    CHECK(a.resultBytes == b.resultBytes);
    CHECK(a.mediaType == b.mediaType);
    CHECK(a.extension == b.extension);
    CHECK(a.report == b.report);
    REQUIRE(a.error.has_value() == b.error.has_value());
    if (!a.error) return;
    CHECK(a.error->code == b.error->code);
    CHECK(a.error->message == b.error->message);
    CHECK(a.error->field == b.error->field);
    CHECK(a.error->limit == b.error->limit);
    CHECK(a.error->actual == b.error->actual);
    CHECK(a.error->setting == b.error->setting);
}

/// Changes the file behind the store's back.
void runSql(const std::string& folder, const std::string& sql) {
    sqlite3* database = nullptr;
    REQUIRE(sqlite3_open((folder + "/jobs.sqlite").c_str(), &database) == SQLITE_OK);
    CHECK(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
    sqlite3_close(database);
}

/// Takes all the room that is left.
void fill(const std::string& path) {
    std::ofstream file(path, std::ios::binary);
    const std::string block(4096, 'x');
    while (file << block << std::flush) {
    }
}

}  // namespace

TEST_SUITE_BEGIN("server/jobs");

TEST_CASE("job store: every field comes back, also in the next process") {
    const test::TemporaryFolder folder;
    JobRecord bare{.id = "0197-a"};
    bare.created = proto::WallTime(1'790'000'000'000ms);
    const JobRecord full = fullRecord();
    {
        const auto store = openStore(folder.path());
        CHECK(loaded(*store).empty());
        REQUIRE(store->save(full));
        REQUIRE(store->save(bare));
    }
    const auto records = loaded(*openStore(folder.path()));
    REQUIRE(records.size() == 2);
    checkSame(records[0], bare);
    checkSame(records[1], full);
}

TEST_CASE("job store: a later record replaces the earlier one, erased ones are gone") {
    const test::TemporaryFolder folder;
    const auto store = openStore(folder.path());
    JobRecord record = fullRecord();
    REQUIRE(store->save(record));
    record.state = JobState::succeeded;
    record.error.reset();
    record.expires.reset();
    REQUIRE(store->save(record));
    REQUIRE(loaded(*store).size() == 1);
    checkSame(loaded(*store)[0], record);

    REQUIRE(store->save({.id = "0198"}));
    CHECK(store->erase(std::vector<std::string>{record.id, "unknown"}));
    CHECK(store->erase({}));
    REQUIRE(loaded(*store).size() == 1);
    CHECK(loaded(*store)[0].id == "0198");
}

TEST_CASE("job store: every error code and state comes back") {
    const test::TemporaryFolder folder;
    const auto store = openStore(folder.path());
    JobRecord record{.id = "a"};
    for (int code = 0; code <= static_cast<int>(ErrorCode::internal); ++code) {
        record.error = core::Error{static_cast<ErrorCode>(code), "why"};
        record.state = static_cast<JobState>(code % 5);
        REQUIRE(store->save(record));
        checkSame(loaded(*store).at(0), record);
    }
}

TEST_CASE("job store: what was saved survives a kill at any moment") {
    const test::TemporaryFolder folder;
    int pipe[2];
    REQUIRE(::pipe(pipe) == 0);
    const pid_t child = ::fork();
    if (child == 0) {
        const auto store = openSqliteJobStore(folder.path());
        for (int i = 100; store; ++i)
            if ((*store)->save({.id = std::to_string(i)}) && ::write(pipe[1], "x", 1) != 1) break;
    }
    char bytes[40];
    std::size_t told = 0;
    while (told < sizeof bytes)
        told += static_cast<std::size_t>(::read(pipe[0], bytes, sizeof bytes - told));
    ::kill(child, SIGKILL);
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    ::close(pipe[1]);
    for (ssize_t n = 0; (n = ::read(pipe[0], bytes, sizeof bytes)) > 0;)
        told += static_cast<std::size_t>(n);
    ::close(pipe[0]);
    const auto records = loaded(*openStore(folder.path()));
    CHECK(records.size() >= told);
    CHECK(records.size() <= told + 1);
}

TEST_CASE("job store: threads save and load at the same time") {
    const test::TemporaryFolder folder;
    const auto store = openStore(folder.path());
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            for (int i = 0; i < 25; ++i) {
                CHECK(store->save({.id = std::to_string(t) + "-" + std::to_string(i)}));
                CHECK(store->load());
                if (i % 5 == 0)
                    CHECK(store->erase(std::vector{std::to_string(t) + "-" + std::to_string(i)}));
            }
        });
    for (std::thread& thread : threads) thread.join();
    CHECK(loaded(*store).size() == 80);
}

TEST_CASE("reject: a store of a newer server, a damaged one, one that is none") {
    const test::TemporaryFolder folder;
    const auto refused = [&](const std::string& part) {
        const auto store = openSqliteJobStore(folder.path());
        REQUIRE_FALSE(store);
        CHECK(store.error().code == ErrorCode::internal);
        CHECK_MESSAGE(store.error().message.find(part) != std::string::npos, store.error().message);
    };
    const std::string path = folder.path() + "/jobs.sqlite";
    static_cast<void>(openStore(folder.path()));
    runSql(folder.path(),
           "WITH RECURSIVE n(i) AS (SELECT 1000 UNION ALL SELECT i + 1 FROM n WHERE i < 1199) "
           "INSERT INTO jobs (id, state, report) SELECT i, 'queued', hex(randomblob(500)) FROM n");
    runSql(folder.path(), "PRAGMA journal_mode = DELETE");
    const std::string whole = test::readFile(path);

    std::string torn = whole;
    torn.replace(torn.size() / 2, 8192, std::string(8192, '\x5a'));
    test::writeFile(path, torn);
    refused("damaged");
    test::writeFile(path, whole.substr(0, whole.size() / 2));
    refused("damaged");
    test::writeFile(path, std::string(9000, 'x'));
    refused("damaged");

    test::writeFile(path, whole);
    runSql(folder.path(), "PRAGMA user_version = 2");
    refused("newer server");
    runSql(folder.path(), "PRAGMA user_version = 1");
    CHECK(loaded(*openStore(folder.path())).size() == 200);
    runSql(folder.path(), "UPDATE jobs SET state = 'odd' WHERE id = '1010'");
    CHECK_FALSE(openStore(folder.path())->load());
}

TEST_CASE("job store: a full disk is named, harms nothing, and ends with the lack of room") {
    const test::SmallDisk disk(1 << 20);
    if (!disk.mounted()) {
        MESSAGE("skipped: only root can mount a small disk");
        return;
    }
    const auto store = openStore(disk.path());
    REQUIRE(store->save({.id = "before"}));
    fill(disk.path() + "/filler");
    JobRecord large{.id = "large"};
    large.report.assign(100'000, 'r');
    const auto saved = store->save(large);
    REQUIRE_FALSE(saved);
    CHECK(saved.error().code == ErrorCode::storageFull);
    CHECK(loaded(*store).size() == 1);

    REQUIRE(::unlink((disk.path() + "/filler").c_str()) == 0);
    CHECK(store->save(large));
    CHECK(loaded(*openStore(disk.path())).size() == 2);
}

TEST_CASE("job store: its files are for this user alone, and its log stays small") {
    const test::TemporaryFolder folder;
    const auto store = openStore(folder.path());
    JobRecord record = fullRecord();
    record.report.assign(20'000, 'r');
    for (int i = 0; i < 200; ++i) {
        record.id = std::to_string(i);
        REQUIRE(store->save(record));
    }
    struct stat status {};
    for (const char* name : {"/jobs.sqlite", "/jobs.sqlite-wal"}) {
        CAPTURE(name);
        REQUIRE(::stat((folder.path() + name).c_str(), &status) == 0);
        CHECK((status.st_mode & 0777) == 0600);
    }
    CHECK(status.st_size < 2 << 20);
}

TEST_SUITE_END();
