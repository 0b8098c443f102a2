// Measures how many records and blobs a second the state folder takes on the disk of $TMPDIR, each
// on the disk before the next.
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "server/jobs/disk_blob_store.h"
#include "server/jobs/sqlite_job_store.h"
#include "tests/support/temporary_folder.h"

namespace {

using namespace rivage;
using Clock = std::chrono::steady_clock;

constexpr double kSeconds = 3;

/// Calls `act(i)` for some time. @return calls a second; negative if one failed
template <typename Act>
double rate(Act act) {
    const auto start = Clock::now();
    double elapsed = 0;
    int calls = 0;
    for (; elapsed < kSeconds; ++calls) {
        if (!act(calls)) return -1;
        elapsed = std::chrono::duration<double>(Clock::now() - start).count();
    }
    return calls / elapsed;
}

double saves(const std::string& folder) {
    const auto store = server::openSqliteJobStore(folder);
    server::JobRecord record;
    record.options = std::string(600, 'o');
    record.report = std::string(2000, 'r');
    return rate([&](int i) {
        record.id = std::to_string(i % 1000);
        return store && (*store)->save(record);
    });
}

double puts(const std::string& folder, std::size_t size) {
    const auto store = server::openDiskBlobStore(folder);
    return rate([&](int i) {
        std::vector<std::byte> bytes(size);
        for (std::size_t k = 0; k < 4; ++k) bytes[k] = static_cast<std::byte>(i >> (8 * k));
        return store && (*store)->put(std::move(bytes));
    });
}

}  // namespace

int main() {
    const test::TemporaryFolder folder;
    std::printf("| what | a second |\n|---|---|\n");
    std::printf("| records saved, 2.6 kB each | %.0f |\n", saves(folder.path()));
    for (const std::size_t size : {std::size_t{1} << 10, std::size_t{1} << 20})
        std::printf("| blobs put, %zu KiB each | %.0f |\n", size >> 10, puts(folder.path(), size));
    return 0;
}
