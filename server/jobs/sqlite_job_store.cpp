#include "server/jobs/sqlite_job_store.h"

#include <chrono>
#include <mutex>
#include <optional>
#include <utility>

#include "proto/problem.h"
#include "server/jobs/file.h"
#include "server/jobs/sqlite.h"

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;
using proto::JobState;
using proto::Json;
using proto::WallTime;

/// Of the table below; a server refuses the files of a newer one.
constexpr std::int64_t kSchemaVersion = 1;

/// Every column and the field that it holds: the one list from which all SQL is made.
template <typename Record, typename Visit>
void eachField(Record& record, Visit&& visit) {
    visit("id", record.id);
    visit("owner", record.owner);
    visit("idempotency_key", record.idempotencyKey);
    visit("key", record.key);
    visit("options", record.options);
    visit("name", record.name);
    visit("request_id", record.requestId);
    visit("traceparent", record.traceparent);
    visit("input_sha256", record.inputSha256);
    visit("input_bytes", record.inputBytes);
    visit("state", record.state);
    visit("stage", record.stage);
    visit("attempt", record.attempt);
    visit("created", record.created);
    visit("started", record.started);
    visit("finished", record.finished);
    visit("expires", record.expires);
    visit("result_sha256", record.resultSha256);
    visit("result_bytes", record.resultBytes);
    visit("media_type", record.mediaType);
    visit("extension", record.extension);
    visit("report", record.report);
    visit("error", record.error);
}

/// "id, owner, ...", each name put through `form`.
template <typename Form>
std::string columns(Form&& form) {
    std::string list;
    JobRecord any;
    eachField(any, [&](const std::string& name, const auto&) {
        list += (list.empty() ? "" : ", ") + form(name);
    });
    return list;
}

std::string plain(const std::string& name) { return name; }

/// Codes are kept by the name of their problem, which outlives the numbers of the enumeration.
std::string errorText(const core::Error& error) {
    Json json{{"problem", std::string(proto::problemType(error.code).slug)},
              {"message", error.message},
              {"field", error.field},
              {"setting", error.setting}};
    if (error.limit) json["limit"] = *error.limit;
    if (error.actual) json["actual"] = *error.actual;
    return proto::writeJson(json);
}

ErrorCode codeOf(const std::string& slug) {
    const int count = static_cast<int>(ErrorCode::internal);
    for (int i = 0; i < count; ++i)
        if (proto::problemType(static_cast<ErrorCode>(i)).slug == slug)
            return static_cast<ErrorCode>(i);
    return ErrorCode::internal;
}

std::optional<core::Error> errorFromText(const std::string& text) {
    try {
        const Json json = Json::parse(text);
        core::Error error{codeOf(json.at("problem")), json.at("message")};
        error.field = json.at("field");
        error.setting = json.at("setting");
        if (json.contains("limit")) error.limit = json["limit"].get<std::uint64_t>();
        if (json.contains("actual")) error.actual = json["actual"].get<std::uint64_t>();
        return error;
    } catch (const Json::exception&) {
        return std::nullopt;
    }
}

/// Puts the fields of a record into a statement, in the order of `eachField`.
class Writer {
public:
    explicit Writer(Statement& statement) : statement_(statement) {}
    void operator()(const char*, const std::string& text) { statement_.bind(++column_, text); }
    void operator()(const char*, std::uint64_t number) {
        statement_.bind(++column_, static_cast<std::int64_t>(number));
    }
    void operator()(const char*, int number) { statement_.bind(++column_, std::int64_t{number}); }
    void operator()(const char*, JobState state) {
        statement_.bind(++column_, std::string(proto::stateName(state)));
    }
    void operator()(const char*, WallTime time) { statement_.bind(++column_, milliseconds(time)); }
    void operator()(const char*, const std::optional<WallTime>& time) {
        if (time) return statement_.bind(++column_, milliseconds(*time));
        statement_.bindNull(++column_);
    }
    void operator()(const char*, const std::optional<core::Error>& error) {
        if (error) return statement_.bind(++column_, errorText(*error));
        statement_.bindNull(++column_);
    }

private:
    static std::int64_t milliseconds(WallTime time) {
        return std::chrono::floor<std::chrono::milliseconds>(time.time_since_epoch()).count();
    }
    Statement& statement_;
    int column_ = 0;
};

/// Takes the fields of a record out of a row, in the order of `eachField`.
class Reader {
public:
    explicit Reader(const Statement& row) : row_(row) {}
    [[nodiscard]] bool failed() const { return failed_; }
    void operator()(const char*, std::string& text) { text = row_.text(++column_); }
    void operator()(const char*, std::uint64_t& number) {
        number = static_cast<std::uint64_t>(row_.number(++column_));
    }
    void operator()(const char*, int& number) { number = static_cast<int>(row_.number(++column_)); }
    void operator()(const char*, JobState& state) {
        const auto known = proto::stateFromName(row_.text(++column_));
        failed_ |= !known;
        state = known.value_or(JobState::failed);
    }
    void operator()(const char*, WallTime& time) { time = timeAt(++column_); }
    void operator()(const char*, std::optional<WallTime>& time) {
        time.reset();
        if (!row_.isNull(++column_)) time = timeAt(column_);
    }
    void operator()(const char*, std::optional<core::Error>& error) {
        error.reset();
        if (row_.isNull(++column_)) return;
        error = errorFromText(row_.text(column_));
        failed_ |= !error;
    }

private:
    [[nodiscard]] WallTime timeAt(int column) const {
        return WallTime(std::chrono::milliseconds(row_.number(column)));
    }
    const Statement& row_;
    int column_ = -1;
    bool failed_ = false;
};

class SqliteJobStore final : public JobStore {
public:
    explicit SqliteJobStore(Database database) : database_(std::move(database)) {}

    core::Result<void> prepare();
    core::Result<void> save(const JobRecord& record) override;
    core::Result<void> erase(std::span<const std::string> ids) override;
    core::Result<std::vector<JobRecord>> load() override;

private:
    core::Result<void> setUpSchema();
    core::Result<void> eraseEach(std::span<const std::string> ids);

    std::mutex mutex_;
    Database database_;  // the statements below go first
    std::optional<Statement> save_;
    std::optional<Statement> erase_;
    std::optional<Statement> load_;
};

core::Result<void> SqliteJobStore::prepare() {
    if (auto made = setUpSchema(); !made) return made;
    const auto place = [](const std::string&) { return std::string("?"); };
    const auto set = [](const std::string& name) { return name + " = excluded." + name; };
    const std::pair<std::optional<Statement>*, std::string> statements[] = {
        {&save_, "INSERT INTO jobs (" + columns(plain) + ") VALUES (" + columns(place) +
                     ") ON CONFLICT (id) DO UPDATE SET " + columns(set)},
        {&erase_, "DELETE FROM jobs WHERE id = ?"},
        {&load_, "SELECT " + columns(plain) + " FROM jobs ORDER BY id"}};
    for (const auto& [statement, sql] : statements) {
        auto prepared = Statement::prepare(database_.get(), sql);
        if (!prepared) return fail(prepared.error());
        *statement = *std::move(prepared);
    }
    return {};
}

core::Result<void> SqliteJobStore::setUpSchema() {
    auto query = Statement::prepare(database_.get(), "PRAGMA user_version");
    if (!query) return fail(query.error());
    if (const auto row = query->step(); !row) return fail(row.error());
    const std::int64_t version = query->number(0);
    query->reset();
    if (version > kSchemaVersion)
        return fail(ErrorCode::internal, "the job store was written by a newer server (version " +
                                             std::to_string(version) + ", this one reads " +
                                             std::to_string(kSchemaVersion) +
                                             "): run that one, or name another "
                                             "--state-dir");
    if (version == kSchemaVersion) return {};
    const auto column = [](const std::string& name) {
        return name + (name == "id" ? " TEXT NOT NULL PRIMARY KEY" : "");
    };
    const std::string sql =
        "BEGIN; CREATE TABLE jobs (" + columns(column) +
        ") WITHOUT ROWID; PRAGMA user_version = " + std::to_string(kSchemaVersion) + "; COMMIT;";
    return execute(database_.get(), sql.c_str());
}

core::Result<void> SqliteJobStore::save(const JobRecord& record) {
    const std::lock_guard lock(mutex_);
    eachField(record, Writer(*save_));
    return save_->run();
}

core::Result<void> SqliteJobStore::erase(std::span<const std::string> ids) {
    if (ids.empty()) return {};
    const std::lock_guard lock(mutex_);
    if (auto begun = execute(database_.get(), "BEGIN IMMEDIATE"); !begun) return begun;
    auto erased = eraseEach(ids);
    if (erased) erased = execute(database_.get(), "COMMIT");
    // A failure may have ended the transaction already; then this finds nothing to do.
    if (!erased) static_cast<void>(execute(database_.get(), "ROLLBACK"));
    return erased;
}

core::Result<void> SqliteJobStore::eraseEach(std::span<const std::string> ids) {
    for (const std::string& id : ids) {
        erase_->bind(1, id);
        if (auto erased = erase_->run(); !erased) return erased;
    }
    return {};
}

core::Result<std::vector<JobRecord>> SqliteJobStore::load() {
    const std::lock_guard lock(mutex_);
    std::vector<JobRecord> records;
    load_->reset();
    auto row = load_->step();
    for (; row && *row; row = load_->step()) {
        Reader reader(*load_);
        eachField(records.emplace_back(), reader);
        if (!reader.failed()) continue;
        row = fail(ErrorCode::internal,
                   "the job store has a record that makes no sense: " + records.back().id);
        break;
    }
    load_->reset();
    if (!row) return fail(row.error());
    return records;
}

}  // namespace

core::Result<std::unique_ptr<JobStore>> openSqliteJobStore(const std::string& folder) {
    if (auto made = makeFolder(folder); !made) return fail(made.error());
    auto database = openDatabase(folder + "/jobs.sqlite");
    if (!database) return fail(database.error());
    auto store = std::make_unique<SqliteJobStore>(*std::move(database));
    if (auto prepared = store->prepare(); !prepared) return fail(prepared.error());
    return store;
}

}  // namespace rivage::server
