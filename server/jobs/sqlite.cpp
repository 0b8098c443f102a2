#include "server/jobs/sqlite.h"

#include <fcntl.h>

#include <cerrno>
#include <utility>

#include "server/jobs/file.h"

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

/// The log is written back at 1 MiB, and cut to that after a peak. `busy_timeout` is for operators
/// who look into the file while the server runs.
constexpr const char* kPragmas =
    "PRAGMA busy_timeout = 5000;"
    "PRAGMA journal_mode = WAL;"
    "PRAGMA synchronous = FULL;"
    "PRAGMA wal_autocheckpoint = 256;"
    "PRAGMA journal_size_limit = 1048576;";

core::Error damaged(const std::string& path, const std::string& finding) {
    return {ErrorCode::internal, "the job store " + path + " is damaged (" + finding +
                                     "): restore it, or move it away to start with an empty one"};
}

bool isDamage(sqlite3* database) {
    const int code = sqlite3_errcode(database);
    return code == SQLITE_CORRUPT || code == SQLITE_NOTADB;
}

core::Result<void> checkDatabase(sqlite3* database, const std::string& path) {
    auto check = Statement::prepare(database, "PRAGMA quick_check(1)");
    const auto row = check ? check->step() : core::Result<bool>(false);
    if (row && *row && check->text(0) == "ok") return {};
    return fail(damaged(path, row && *row ? check->text(0) : sqlite3_errmsg(database)));
}

}  // namespace

core::Error databaseError(sqlite3* database) {
    const int code = sqlite3_extended_errcode(database);
    const int cause = sqlite3_system_errno(database);
    if (code == SQLITE_FULL || code == SQLITE_IOERR_WRITE || code == SQLITE_IOERR_SHMSIZE ||
        cause == ENOSPC || cause == EDQUOT)
        return diskError("keep this job", ENOSPC);
    return {ErrorCode::internal,
            "the server could not reach its job store: " + std::string(sqlite3_errstr(code))};
}

core::Result<Statement> Statement::prepare(sqlite3* database, const std::string& sql) {
    sqlite3_stmt* statement = nullptr;
    const int code = sqlite3_prepare_v3(database, sql.c_str(), static_cast<int>(sql.size()),
                                        SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
    if (code != SQLITE_OK) return fail(databaseError(database));
    return Statement(statement);
}

void Statement::bind(int column, const std::string& text) {
    sqlite3_bind_text(statement_.get(), column, text.data(), static_cast<int>(text.size()),
                      SQLITE_TRANSIENT);
}

void Statement::bind(int column, std::int64_t number) {
    sqlite3_bind_int64(statement_.get(), column, number);
}

void Statement::bindNull(int column) { sqlite3_bind_null(statement_.get(), column); }

core::Result<bool> Statement::step() {
    const int code = sqlite3_step(statement_.get());
    if (code == SQLITE_ROW || code == SQLITE_DONE) return code == SQLITE_ROW;
    return fail(databaseError(sqlite3_db_handle(statement_.get())));
}

core::Result<void> Statement::run() {
    auto row = step();
    while (row && *row) row = step();
    reset();
    if (!row) return fail(row.error());
    return {};
}

void Statement::reset() {
    sqlite3_reset(statement_.get());
    sqlite3_clear_bindings(statement_.get());
}

std::string Statement::text(int column) const {
    const unsigned char* const bytes = sqlite3_column_text(statement_.get(), column);
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
    return bytes ? std::string(reinterpret_cast<const char*>(bytes), size) : std::string();
}

std::int64_t Statement::number(int column) const {
    return sqlite3_column_int64(statement_.get(), column);
}

bool Statement::isNull(int column) const {
    return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL;
}

core::Result<void> execute(sqlite3* database, const char* sql) {
    if (sqlite3_exec(database, sql, nullptr, nullptr, nullptr) == SQLITE_OK) return {};
    return fail(databaseError(database));
}

core::Result<Database> openDatabase(const std::string& path) {
    // Made here, so that it and the files that SQLite puts beside it get these rights.
    const Fd file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
    if (!file) return fail(diskError("open its job store", errno));
    sqlite3* raw = nullptr;
    const int code =
        sqlite3_open_v2(path.c_str(), &raw, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, nullptr);
    Database database(raw);
    if (code != SQLITE_OK) return fail(databaseError(raw));
    if (auto set = execute(raw, kPragmas); !set)
        return fail(isDamage(raw) ? damaged(path, sqlite3_errmsg(raw)) : set.error());
    if (auto sound = checkDatabase(raw, path); !sound) return fail(sound.error());
    return database;
}

}  // namespace rivage::server
