// check_store FOLDER: checks the job store of a state folder that no server uses: the database is
// sound and every record can be read. Exit code 1 if not.
#include <cstdio>
#include <string>

#include "server/jobs/sqlite.h"
#include "server/jobs/sqlite_job_store.h"

using namespace rivage;

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    const std::string folder = argv[1];
    const auto fail = [](const std::string& message) {
        std::printf("%s\n", message.c_str());
        return 1;
    };
    const auto store = server::openSqliteJobStore(folder);
    if (!store) return fail(store.error().message);
    const auto records = (*store)->load();
    if (!records) return fail(records.error().message);
    const auto database = server::openDatabase(folder + "/jobs.sqlite");
    if (!database) return fail(database.error().message);
    auto check = server::Statement::prepare(database->get(), "PRAGMA integrity_check");
    const auto row = check ? check->step() : core::Result<bool>(false);
    if (!row || !*row || check->text(0) != "ok") return fail("integrity_check does not say ok");
    std::printf("ok, %zu records\n", records->size());
    return 0;
}
