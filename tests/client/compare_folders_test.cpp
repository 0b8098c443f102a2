#include <doctest/doctest.h>

#include "tests/client/fake_server.h"
#include "tests/client/run.h"

namespace rivage::client {
namespace {

/// An OBJ with one triangle at a height.
std::string triangleAt(const std::string& z) {
    return "v 0 0 " + z + "\nv 1 0 " + z + "\nv 0 1 " + z + "\nf 1 2 3\n";
}

struct Folders {
    TemporaryFolder folder;
    Folders() {
        for (const char* name : {"a/deep", "b/deep"})
            std::filesystem::create_directories(folder / name);
        for (const char* side : {"a", "b"})
            writeFile(folder / (std::string(side) + "/same.obj"), triangleAt("0"));
        writeFile(folder / "a/deep/moved.obj", triangleAt("0"));
        writeFile(folder / "b/deep/moved.obj", triangleAt("0.5"));
    }
    Run& compare(Run& run, std::vector<std::string> more = {}) {
        more.insert(more.begin(), {"compare", folder / "a", folder / "b", "--voxel-size", "1"});
        return run(more);
    }
};

bool says(const Run& run, const std::string& text) {
    return run.out.str().find(text) != std::string::npos;
}

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("compare: two folders, file by file") {
    Folders folders;
    Run run;
    folders.compare(run);
    CHECK(run.code == ExitCode::ok);
    CHECK(says(run, "deep/moved.obj"));
    CHECK(says(run, "differs (max distance 0.5 voxel)"));
    CHECK(says(run, "same bytes"));
    CHECK(run.out.str().ends_with("\n1 same, 1 different\n"));

    Run near;
    CHECK(folders.compare(near, {"--max-distance", "0.6"}).code == ExitCode::ok);
    Run far;
    CHECK(folders.compare(far, {"--max-distance", "0.4"}).code == ExitCode::failed);
    CHECK(says(far, "1 same, 1 beyond --max-distance"));
}

TEST_CASE("compare: a file without partner is named, and fails where a limit is set") {
    Folders folders;
    writeFile(folders.folder / "b/more.obj", triangleAt("0"));
    Run run;
    folders.compare(run);
    CHECK(run.code == ExitCode::ok);
    CHECK(says(run, "only in " + (folders.folder / "b")));
    Run limited;
    CHECK(folders.compare(limited, {"--max-distance", "1"}).code == ExitCode::failed);
    Run json;
    folders.compare(json, {"--json"});
    std::istringstream lines(json.out.str());
    std::vector<std::string> files;
    for (std::string line; std::getline(lines, line);)
        files.push_back(proto::Json::parse(line)["file"]);
    CHECK(files == std::vector<std::string>{"deep/moved.obj", "same.obj", "more.obj"});
}

TEST_CASE("reject: compare with a broken file, a folder and a file, empty folders") {
    Folders folders;
    writeFile(folders.folder / "b/same.obj", "no triangles");
    Run run;
    CHECK(folders.compare(run).code == ExitCode::refused);
    CHECK(run.err.str().find("b/same.obj") != std::string::npos);
    CHECK(says(run, "0 same, 1 different, 1 not compared"));
    Run mixed;
    mixed({"compare", folders.folder / "a", folders.folder / "a/same.obj"});
    CHECK(mixed.code == ExitCode::usage);
    std::filesystem::create_directory(folders.folder / "none");
    Run none;
    none({"compare", folders.folder / "none", folders.folder / "none"});
    CHECK(none.code == ExitCode::usage);
    Run stopped;
    stopped.interrupt.request();
    CHECK(folders.compare(stopped).code == ExitCode::cancelled);
    CHECK(stopped.out.str().empty());
}

TEST_SUITE_END();

}  // namespace rivage::client
