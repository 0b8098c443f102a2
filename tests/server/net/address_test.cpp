#include "server/net/address.h"

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::server;

namespace {

/// A folder that is gone at the end of the test.
struct Folder {
    std::string path;
    Folder() {
        path = (std::filesystem::temp_directory_path() / "rivage-test-XXXXXX").string();
        REQUIRE(::mkdtemp(path.data()) != nullptr);
    }
    ~Folder() { std::filesystem::remove_all(path); }
};

void leaveDeadSocket(const std::string& path) {
    const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    REQUIRE(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    ::close(socket);
}

}  // namespace

TEST_SUITE_BEGIN("server/net");

TEST_CASE("parseAddress: host and port, IPv6, Unix sockets") {
    CHECK(parseAddress("127.0.0.1:8080")->url() == "http://127.0.0.1:8080");
    CHECK(parseAddress("[::1]:0")->url() == "http://[::1]:0");
    CHECK(parseAddress(":80")->host == "0.0.0.0");
    CHECK(parseAddress("unix:/run/x.sock")->url() == "unix:/run/x.sock");
    for (const std::string& text : {std::string(), std::string("localhost"), std::string("a:b"),
                                    std::string("a:65536"), std::string("a:-1"), std::string("a:"),
                                    std::string("unix:"), "unix:/" + std::string(120, 'x')}) {
        CAPTURE(text);
        CHECK_FALSE(parseAddress(text));
    }
}

TEST_CASE("HttpServer: a Unix socket, removed at the end; a dead one is replaced") {
    const Folder folder;
    const std::string path = folder.path + "/s";
    leaveDeadSocket(path);
    {
        const test::TestServer server({.listen = "unix:" + path});
        auto client = server.client();
        const auto version = client.Get("/version");
        REQUIRE(version);
        CHECK(version->status == 200);
        struct stat status {};
        REQUIRE(::stat(path.c_str(), &status) == 0);
        CHECK((status.st_mode & 0777) == 0660);
        CHECK(clearStaleSocket(path).error().code == core::ErrorCode::busy);
        CHECK(client.Post("/v1/regularize", "ok", "application/octet-stream")->status == 200);
    }
    CHECK_FALSE(std::filesystem::exists(path));
}

TEST_CASE("reject: a path that is something else than a socket") {
    const Folder folder;
    std::ofstream(folder.path + "/f") << "precious";
    CHECK_FALSE(clearStaleSocket(folder.path + "/f"));
    CHECK(std::filesystem::exists(folder.path + "/f"));
}

TEST_SUITE_END();
