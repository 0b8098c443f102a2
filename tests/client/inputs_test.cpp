#include "client/inputs.h"

#include <doctest/doctest.h>
#include <sys/fsuid.h>
#include <unistd.h>

#include "tests/client/fake_server.h"
#include "tests/client/run.h"

namespace rivage::client {
namespace {

/// A folder with grids at three depths, a hidden one, and what is no grid.
struct Tree {
    TemporaryFolder folder;
    Tree() {
        for (const char* name : {"models/a/deep", "models/.git", "models/empty"})
            std::filesystem::create_directories(folder / name);
        for (const char* name :
             {"models/b.vox", "models/README.md", "models/a/c.NPY", "models/z.nii.gz",
              "models/z.gz", "models/a/deep/d.vox", "models/.git/e.vox", "models/.f.vox"})
            writeFile(folder / name, "x");
    }
    [[nodiscard]] std::vector<std::string> find(const std::string& name) const {
        const auto inputs = findInputs({name}, {".vox", ".npy", ".nii.gz"}, true);
        std::vector<std::string> below;
        for (const InputFile& file : inputs->files) below.push_back(file.below);
        return below;
    }
};

using Names = std::vector<std::string>;

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("inputs: patterns") {
    const auto matches = [](const char* path, const char* pattern) {
        return matchesPattern(path, pattern);
    };
    CHECK(matches("a.vox", "*.vox"));
    CHECK(matches("a.vox", "?.vox"));
    CHECK(matches("b.vox", "[a-c].vox"));
    CHECK_FALSE(matches("b.vox", "[!a-c].vox"));
    CHECK_FALSE(matches("x/a.vox", "*.vox"));
    CHECK(matches("x/a.vox", "*/*.vox"));
    CHECK(matches("a.vox", "**/*.vox"));
    CHECK(matches("x/y/z/a.vox", "**/*.vox"));
    CHECK(matches("x/y/z/a.vox", "x/**/a.vox"));
    CHECK(matches("x/a.vox", "x/**/a.vox"));
    CHECK_FALSE(matches("y/a.vox", "x/**/a.vox"));
    CHECK(matches("x/y", "**"));
    CHECK_FALSE(matches(".a.vox", "*.vox"));
    CHECK_FALSE(matches("x/.y/a.vox", "**/*.vox"));
    CHECK(matches(".a.vox", ".*.vox"));
}

TEST_CASE("inputs: folders and patterns, sorted, each file once") {
    const Tree tree;
    CHECK(tree.find(tree.folder / "models") ==
          Names{"a/c.NPY", "a/deep/d.vox", "b.vox", "z.nii.gz"});
    CHECK(tree.find(tree.folder / "models/**/*.vox") == Names{"a/deep/d.vox", "b.vox"});
    CHECK(tree.find(tree.folder / "models/*") == Names{"README.md", "b.vox", "z.gz", "z.nii.gz"});
    CHECK(tree.find(tree.folder / "mod*/*.vox") == Names{"models/b.vox"});
    CHECK(tree.find(tree.folder / "models/empty").empty());
    CHECK(tree.find(tree.folder / "models/b.vox") == Names{"b.vox"});
    CHECK(tree.find(tree.folder / "not there.vox") == Names{"not there.vox"});

    const auto twice = findInputs({tree.folder / "models/b.vox", tree.folder / "models",
                                   tree.folder / "models/../models/b.vox"},
                                  {".vox"}, false);
    REQUIRE(twice);
    CHECK(twice->files.size() == 2);
}

TEST_CASE("reject: folders and patterns without grids") {
    const Tree tree;
    for (const std::string name : {"models/empty", "models/*.nrrd", "nowhere/*"}) {
        CAPTURE(name);
        const auto inputs = findInputs({tree.folder / name}, {".vox"}, false);
        REQUIRE_FALSE(inputs);
        CHECK(inputs.error().exit == ExitCode::usage);
    }
}

TEST_CASE("inputs: what a search meets and cannot read is named") {
    const Tree tree;
    namespace fs = std::filesystem;
    fs::create_symlink("loop.vox", tree.folder / "models/loop.vox");
    fs::create_symlink("nothing", tree.folder / "models/gone.vox");
    fs::create_symlink("nothing", tree.folder / "models/gone.txt");
    fs::create_symlink("..", tree.folder / "models/a/up");
    // A name that no system call takes: the superuser, who may read all, cannot read this either.
    std::string deep = tree.folder / "models";
    fs::path back = fs::current_path();
    fs::current_path(deep);
    for (int i = 0; i < 20; ++i) {
        fs::create_directory(std::string(250, 'd'));
        fs::current_path(std::string(250, 'd'));
    }
    fs::current_path(back);
    const auto inputs = findInputs({tree.folder / "models"}, {".vox"}, false);
    REQUIRE(inputs);
    CHECK(inputs->files.size() == 2);
    REQUIRE(inputs->unread.size() == 3);
    CHECK(inputs->unread[0].why.find("name too long") != std::string::npos);
    CHECK(inputs->unread[1].path.ends_with("gone.vox"));
    CHECK(inputs->unread[2].path.ends_with("loop.vox"));
}

TEST_CASE("inputs: a folder that may not be read is named, and the others are found") {
    const Tree tree;
    namespace fs = std::filesystem;
    const fs::path back = fs::current_path();
    fs::current_path(tree.folder / "models");
    for (const char* name : {".", "a"}) fs::permissions(name, fs::perms(0755));
    fs::permissions("a/deep", fs::perms::none);
    // The superuser may read it: as somebody else then, as far as files go.
    constexpr uid_t kNobody = 65534;
    const int before = setfsuid(geteuid() == 0 ? kNobody : geteuid());
    const auto inputs = findInputs({"."}, {".vox"}, false);
    setfsuid(static_cast<uid_t>(before));
    fs::permissions("a/deep", fs::perms::owner_all);
    fs::current_path(back);
    REQUIRE(inputs);
    REQUIRE(inputs->files.size() == 1);
    CHECK(inputs->files[0].below == "b.vox");
    REQUIRE(inputs->unread.size() == 1);
    CHECK(inputs->unread[0].path.ends_with("a/deep"));
    CHECK(inputs->unread[0].why == "Permission denied");
}

TEST_CASE("inputs: a name with a bracket that is a file is no pattern") {
    const TemporaryFolder folder;
    writeFile(folder / "a[1].vox", "x");
    const auto inputs = findInputs({folder / "a[1].vox"}, {".vox"}, false);
    REQUIRE(inputs);
    CHECK(inputs->files.size() == 1);
    CHECK_FALSE(inputs->many);
}

TEST_SUITE_END();

}  // namespace rivage::client
