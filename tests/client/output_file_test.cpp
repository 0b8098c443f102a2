#include "client/output_file.h"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <thread>

#include "tests/client/fake_server.h"

namespace rivage::client {
namespace {

std::string contentOf(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("output file: appears when it is committed, whole") {
    const TemporaryFolder folder;
    {
        auto file = OutputFile::open(folder / "a.glb");
        REQUIRE(file);
        CHECK(file->write("half"));
        CHECK_FALSE(std::filesystem::exists(folder / "a.glb"));
        CHECK(file->restart());
        CHECK(file->write("all of it"));
        CHECK(file->size() == 9);
        CHECK(file->commit());
    }
    CHECK(contentOf(folder / "a.glb") == "all of it");
    CHECK(folder.entries() == 1);
}

TEST_CASE("output file: dropped without commit it leaves the old file alone") {
    const TemporaryFolder folder;
    std::ofstream(folder / "a.glb") << "old";
    {
        auto file = OutputFile::open(folder / "a.glb");
        REQUIRE(file);
        CHECK(file->write("new"));
    }
    CHECK(contentOf(folder / "a.glb") == "old");
    CHECK(folder.entries() == 1);
}

TEST_CASE("output file: replaces what a link points to and keeps its mode") {
    const TemporaryFolder folder;
    std::ofstream(folder / "real") << "old";
    chmod((folder / "real").c_str(), 0640);
    std::filesystem::create_symlink(folder / "real", folder / "link");
    auto file = OutputFile::open(folder / "link");
    REQUIRE(file);
    CHECK(file->write("new"));
    CHECK(file->commit());
    CHECK(std::filesystem::is_symlink(folder / "link"));
    CHECK(contentOf(folder / "real") == "new");
    struct stat status {};
    stat((folder / "real").c_str(), &status);
    CHECK((status.st_mode & 0777) == 0640);
}

TEST_CASE("output file: a device is written, not replaced") {
    auto file = OutputFile::open("/dev/null");
    REQUIRE(file);
    CHECK(file->write("x"));
    CHECK(file->commit());
    CHECK(std::filesystem::is_character_file("/dev/null"));
}

TEST_CASE("output file: a name of as many bytes as a name may have") {
    const TemporaryFolder folder;
    // Characters of two bytes, so that the temporary name has to be cut between two of them.
    std::string name = "x";
    while (name.size() < 251) name += "\xc3\xa4";
    name += ".glb";
    REQUIRE(name.size() == 255);
    auto file = OutputFile::open(folder / name);
    REQUIRE(file);
    CHECK(file->write("all of it"));
    CHECK(file->commit());
    CHECK(contentOf(folder / name) == "all of it");
    CHECK(folder.entries() == 1);
}

TEST_CASE("output file: a pipe waits for its reader, and for a slow one, until a stop") {
    const TemporaryFolder folder;
    const std::string pipe = folder / "pipe";
    REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
    const std::string bytes(300'000, 'x');  // more than a pipe holds
    std::thread reader([&] { CHECK(contentOf(pipe) == bytes); });
    {
        auto file = OutputFile::open(pipe);
        REQUIRE(file);
        CHECK(file->write(bytes));
        CHECK(file->commit());
    }
    reader.join();

    Interrupt interrupt;
    interrupt.request();
    const auto stopped = OutputFile::open(pipe, &interrupt);
    REQUIRE_FALSE(stopped);
    CHECK(stopped.error().exit == ExitCode::cancelled);

    Interrupt later;
    const int idle = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
    auto file = OutputFile::open(pipe, &later);
    REQUIRE(file);
    std::thread person([&] { later.request(); });
    CHECK_FALSE(file->write(bytes));
    person.join();
    CHECK_FALSE(file->commit());
    ::close(idle);
}

TEST_CASE("reject: a full device is noticed") {
    auto file = OutputFile::open("/dev/full");
    REQUIRE(file);
    CHECK_FALSE(file->write("x"));
    const auto committed = file->commit();
    REQUIRE_FALSE(committed);
    CHECK(committed.error().exit == ExitCode::notWritten);
}

TEST_CASE("reject: a folder, or a place that is not there") {
    const TemporaryFolder folder;
    CHECK_FALSE(OutputFile::open(folder / ""));
    CHECK_FALSE(OutputFile::open(folder / "no/file"));
    CHECK(folder.entries() == 0);
}

TEST_SUITE_END();

}  // namespace rivage::client
