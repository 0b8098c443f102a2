#include <doctest/doctest.h>

#include <filesystem>

#include "client/reference/reference.h"
#include "sample_tree.h"
#include "shells.h"
#include "tests/support/temporary_folder.h"

using namespace rivage::client;

namespace {

using Words = std::vector<std::string>;

/// Words as one text, so that a check that fails shows them.
std::string listed(const Words& words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
    return text;
}

std::string scriptOf(Shell shell) {
    const SampleTree tree;
    return completionScript(tree.app, shell);
}

/// A folder with a file and a folder in it.
struct Place {
    rivage::test::TemporaryFolder folder;
    Place() {
        rivage::test::writeFile(path() + "/grid.vox", "x");
        std::filesystem::create_directory(path() + "/results");
    }
    [[nodiscard]] std::string path() const { return folder.path(); }
};

/// What every shell must offer alike.
void checkShell(Shell shell) {
    const Place place;
    const std::string script = scriptOf(shell);
    const auto ask = [&](const std::string& line) {
        return listed(offers(shell, script, "sample-tool " + line, place.path()));
    };

    CHECK(ask("") == "convert jobs shell");
    CHECK(ask("j") == "jobs");
    CHECK(ask("jobs ") == "fetch list");
    CHECK(ask("--server http://x:1 -q jobs f") == "fetch");
    CHECK(ask("shell ") == "bash fish");

    CHECK(ask("convert --pack ") == "draco none");
    CHECK(ask("convert --pack d") == "draco");
    CHECK(ask("convert --mode ") == "exact fast");
    CHECK(ask("convert --when ") == "later now");
    CHECK(ask("cv --mode e") == "exact");
    CHECK(ask("convert --tag red ") == "green red");
    CHECK(ask("jobs fetch --resume ") == "no yes");

    CHECK(ask("convert --pa") == "--pack");
    CHECK(ask("convert --gr") == "--grouped");
    CHECK(ask("convert --quie") == "--quiet");  // falls through
    CHECK(ask("jobs fetch --r") == "--resume");
    CHECK(ask("--inn") == "");

    CHECK(ask("convert g") == "grid.vox");
    CHECK(ask("convert --out g") == "grid.vox");
    CHECK(ask("convert -o g") == "grid.vox");
    CHECK(ask("convert --folder g") == "");
    CHECK(ask("convert --server g") == "");
}

}  // namespace

TEST_SUITE("client/reference") {
    TEST_CASE("bash completes commands, options, words and files") {
        checkShell(Shell::bash);
        const Place place;
        CHECK(listed(offers(Shell::bash, scriptOf(Shell::bash), "sample-tool convert --pack=n",
                            place.path())) == "none");
        CHECK(listed(offers(Shell::bash, scriptOf(Shell::bash), "sample-tool convert --folder r",
                            place.path())) == "results");
    }

    TEST_CASE("zsh completes commands, options, words and files" *
              doctest::skip(!isInstalled("zsh"))) {
        checkShell(Shell::zsh);
    }

    TEST_CASE("fish completes commands, options, words and files" *
              doctest::skip(!isInstalled("fish"))) {
        checkShell(Shell::fish);
    }

    TEST_CASE("golden: every option and command of the tree is in every script, hidden ones not") {
        const SampleTree tree;
        Words names;
        collectNames(tree.app, names);
        REQUIRE(names.size() > 15);
        for (const Shell shell : {Shell::bash, Shell::zsh, Shell::fish}) {
            const std::string script = completionScript(tree.app, shell);
            for (const std::string& one : names) {
                CAPTURE(one);
                CHECK(script.find(one) != std::string::npos);
            }
            CHECK(script.find("secret") == std::string::npos);
            CHECK(script.find("hidden-command") == std::string::npos);
            CHECK(script.find("XxYxZ'") == std::string::npos);
        }
    }

    TEST_CASE("shellOf: knows its three shells and no other") {
        CHECK(shellOf("bash") == Shell::bash);
        CHECK(shellOf("zsh") == Shell::zsh);
        CHECK(shellOf("fish") == Shell::fish);
        CHECK_FALSE(shellOf("tcsh"));
        CHECK_FALSE(shellOf(""));
    }
}
