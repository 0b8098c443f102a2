#include "server/jobs/file.h"

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>

#include "tests/support/temporary_folder.h"

using namespace rivage;
using namespace rivage::server;
using core::ErrorCode;

TEST_SUITE_BEGIN("server/jobs");

TEST_CASE("file: a full disk has its own code, and no error names a path") {
    CHECK(diskError("keep", ENOSPC).code == ErrorCode::storageFull);
    CHECK(diskError("keep", EDQUOT).setting == "--state-dir");
    const core::Error other = diskError("keep", EIO);
    CHECK(other.code == ErrorCode::internal);
    CHECK(other.message == "the server could not keep: Input/output error");
}

TEST_CASE("file: folders are made with those above them, for this user alone") {
    const test::TemporaryFolder folder;
    const std::string path = folder.path() + "/a/b/c";
    CHECK(makeFolder(path));
    CHECK(makeFolder(path));
    struct stat status {};
    REQUIRE(::stat(path.c_str(), &status) == 0);
    CHECK((status.st_mode & 0777) == 0700);
    test::writeFile(folder.path() + "/file", "");
    CHECK_FALSE(makeFolder(folder.path() + "/file"));
    CHECK_FALSE(makeFolder(folder.path() + "/file/below"));
}

TEST_CASE("file: a state folder has one server, until it ends or dies") {
    const test::TemporaryFolder folder;
    {
        const auto first = lockFolder(folder.path());
        REQUIRE(first);
        const auto second = lockFolder(folder.path());
        REQUIRE_FALSE(second);
        CHECK(second.error().code == ErrorCode::busy);
        CHECK(second.error().message.find("--state-dir " + folder.path()) != std::string::npos);
    }
    const pid_t child = ::fork();
    if (child == 0) ::_exit(lockFolder(folder.path()) ? 0 : 1);
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    CHECK(status == 0);
    CHECK(lockFolder(folder.path()));
}

TEST_CASE("file: a forked process keeps the lock of the one that took it") {
    const test::TemporaryFolder folder;
    auto lock = lockFolder(folder.path());
    REQUIRE(lock);
    int pipe[2];
    REQUIRE(::pipe(pipe) == 0);
    const pid_t child = ::fork();
    if (child == 0) {
        char byte = 0;
        ::close(pipe[1]);
        ::_exit(static_cast<int>(::read(pipe[0], &byte, 1)));
    }
    *lock = Fd();
    { const Fd dropped = *std::move(lock); }
    CHECK_FALSE(lockFolder(folder.path()));
    ::close(pipe[0]);
    ::close(pipe[1]);
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    CHECK(lockFolder(folder.path()));
}

TEST_SUITE_END();
