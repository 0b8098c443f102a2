#include "client/plan.h"

#include <doctest/doctest.h>

#include <fstream>

#include "tests/client/fake_server.h"

namespace rivage::client {

namespace {

Outcome<std::vector<PlannedFile>> plan(const std::vector<std::string>& names,
                                       const std::string& out) {
    const auto inputs = findInputs(names, {".vox"}, false);
    if (!inputs) return tl::unexpected(inputs.error());
    return planFiles(*inputs, out, "glb");
}

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("plan: where results go") {
    const TemporaryFolder folder;
    const auto outputOf = [](const std::string& input, const std::string& out) {
        return plan({input}, out)->front().output;
    };
    CHECK(outputOf("a/house.vox", "") == "a/house.glb");
    CHECK(outputOf("house", "") == "house.glb");
    CHECK(outputOf("a/brain.nii.gz", "") == "a/brain.glb");
    CHECK(outputOf("a/brain.seg.nrrd", "new/") == "new/brain.seg.glb");
    CHECK(outputOf("house.vox", "x.bin") == "x.bin");
    CHECK(outputOf("a/house.vox", "new/") == "new/house.glb");
    CHECK(outputOf("a/house.vox", folder / "") == folder / "house.glb");
    CHECK(outputOf("-", "") == "-");
    CHECK(outputOf("-", "new/") == "new/stdin.glb");
    CHECK(outputOf("house.vox", "-") == "-");
}

TEST_CASE("reject: two results in one place") {
    CHECK_FALSE(plan({"a/x.vox", "b/x.vox"}, "out/"));
    CHECK_FALSE(plan({"a/x.vox", "a/x.npy"}, ""));
    CHECK_FALSE(plan({"a.vox", "b.vox"}, "one.glb"));
    CHECK_FALSE(plan({"a.vox", "b.vox"}, "-"));
}

TEST_CASE("reject: a result onto its own input") {
    const TemporaryFolder folder;
    std::ofstream(folder / "a.vox") << "x";
    const auto files = plan({folder / "a.vox"}, folder / "./a.vox");
    REQUIRE_FALSE(files);
    CHECK(files.error().exit == ExitCode::usage);
}

TEST_SUITE_END();

}  // namespace rivage::client
