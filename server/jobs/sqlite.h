#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <string>

#include "core/base/result.h"

namespace rivage::server {

/// A prepared statement of SQLite. Not safe for several threads.
class Statement {
public:
    /// @param sql  one statement that the database takes
    /// @errors     storageFull; internal
    static core::Result<Statement> prepare(sqlite3* database, const std::string& sql);

    /// @param column  counts from 1
    void bind(int column, const std::string& text);
    void bind(int column, std::int64_t number);
    void bindNull(int column);
    /// One step. @return whether there is a row to read @errors storageFull; internal
    core::Result<bool> step();
    /// Runs it to its end and makes it ready for the next values.
    core::Result<void> run();
    void reset();

    /// @param column  counts from 0
    [[nodiscard]] std::string text(int column) const;
    [[nodiscard]] std::int64_t number(int column) const;
    [[nodiscard]] bool isNull(int column) const;

private:
    struct Finalize {
        void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
    };
    explicit Statement(sqlite3_stmt* statement) : statement_(statement) {}
    std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

struct CloseDatabase {
    void operator()(sqlite3* database) const { sqlite3_close(database); }
};
using Database = std::unique_ptr<sqlite3, CloseDatabase>;

/// What the last failure of a database means for a client.
[[nodiscard]] core::Error databaseError(sqlite3* database);

/// Runs statements that give no rows. @errors storageFull; internal
core::Result<void> execute(sqlite3* database, const char* sql);

/// Opens a database, in WAL mode with every commit on the disk; makes a file for this user alone.
/// @errors storageFull; internal, also if the file is no sound database
core::Result<Database> openDatabase(const std::string& path);

}  // namespace rivage::server
