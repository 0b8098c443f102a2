#include "client/plan.h"

#include <doctest/doctest.h>

#include <fstream>

#include "tests/client/fake_server.h"

namespace rivage::client {

TEST_SUITE_BEGIN("client");

TEST_CASE("plan: where results go") {
    const TemporaryFolder folder;
    const auto outputOf = [](const std::string& input, const std::string& out) {
        return planFiles({input}, out, "glb")->front().output;
    };
    CHECK(outputOf("a/house.vox", "") == "a/house.glb");
    CHECK(outputOf("house", "") == "house.glb");
    CHECK(outputOf("house.vox", "x.bin") == "x.bin");
    CHECK(outputOf("a/house.vox", "new/") == "new/house.glb");
    CHECK(outputOf("a/house.vox", folder / "") == folder / "house.glb");
    CHECK(outputOf("-", "") == "-");
    CHECK(outputOf("-", "new/") == "new/stdin.glb");
    CHECK(outputOf("house.vox", "-") == "-");
}

TEST_CASE("reject: two results in one place") {
    CHECK_FALSE(planFiles({"a/x.vox", "b/x.vox"}, "out/", "glb"));
    CHECK_FALSE(planFiles({"a/x.vox", "a/x.npy"}, "", "glb"));
    CHECK_FALSE(planFiles({"a.vox", "b.vox"}, "one.glb", "glb"));
    CHECK_FALSE(planFiles({"a.vox", "b.vox"}, "-", "glb"));
}

TEST_CASE("reject: a result onto its own input") {
    const TemporaryFolder folder;
    std::ofstream(folder / "a.vox") << "x";
    const auto files = planFiles({folder / "a.vox"}, folder / "./a.vox", "glb");
    REQUIRE_FALSE(files);
    CHECK(files.error().exit == ExitCode::usage);
}

TEST_SUITE_END();

}  // namespace rivage::client
