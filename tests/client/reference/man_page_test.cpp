#include <doctest/doctest.h>

#include "client/reference/reference.h"
#include "sample_tree.h"
#include "shells.h"
#include "tests/support/temporary_folder.h"

using namespace rivage::client;

namespace {

ManPageText sampleText() {
    return {.version = "Sample 1.2.3",
            .description = "First paragraph\nof two lines.\n\n.Not a request, \\n either.",
            .environment = {{"SAMPLE_KEY", "A key."}, {"SAMPLE_SERVER", "Never shown."}},
            .files = {{"~/.config/sample", "What is set."}},
            .exitStatus = {{"0", "done"}, {"2", "not done"}},
            .examples = {{"sample-tool convert 'a b' --out -", "Convert it:"}},
            .seeAlso = {"other-tool(1)", "man(7)"},
            .date = "2026-01-31"};
}

std::string pageOf() {
    const SampleTree tree;
    return manPage(tree.app, sampleText());
}

/// The page as a reader sees it, without bold and underline.
std::string rendered(const std::string& page, int& status) {
    const rivage::test::TemporaryFolder folder;
    const std::string file = folder.path() + "/sample-tool.1";
    rivage::test::writeFile(file, page);
    return outputOf("groff -man -Tascii -ww -P -cbou -rLL=200n " + file, status);
}

/// What a program says of the page.
/// @param after  what follows the name of the file on its command line
std::string complaints(const std::string& program, const std::string& after) {
    const rivage::test::TemporaryFolder folder;
    const std::string file = folder.path() + "/sample-tool.1";
    rivage::test::writeFile(file, pageOf());
    int status = 0;
    const std::string words = outputOf(
        "export LC_ALL=C.UTF-8 MANROFFSEQ= MANWIDTH=80; " + program + " " + file + after, status);
    return status == 0 ? words : program + " failed: " + words;
}

}  // namespace

TEST_SUITE("client/reference") {
    TEST_CASE("manPage: every section in the customary order") {
        const std::string page = pageOf();
        std::size_t last = 0;
        for (const char* title : {"NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS", "COMMANDS",
                                  "ENVIRONMENT", "FILES", "EXIT STATUS", "EXAMPLES", "SEE ALSO"}) {
            CAPTURE(title);
            const std::size_t at = page.find(std::string(".SH ") + title + "\n");
            REQUIRE(at != std::string::npos);
            CHECK(at > last);
            last = at;
        }
    }

    TEST_CASE("manPage: parts without content are left out") {
        const SampleTree tree;
        const std::string page = manPage(tree.app, {});
        for (const char* title : {"DESCRIPTION", "FILES", "EXIT STATUS", "EXAMPLES", "SEE ALSO"})
            CHECK(page.find(std::string(".SH ") + title) == std::string::npos);
        CHECK(page.find("SAMPLE_SERVER") != std::string::npos);
    }

    TEST_CASE("golden: every option and command of the tree is in the page, hidden ones not") {
        const SampleTree tree;
        std::vector<std::string> names;
        collectNames(tree.app, names);
        int status = 0;
        const std::string text = rendered(pageOf(), status);
        REQUIRE(status == 0);
        for (const std::string& name : names) {
            CAPTURE(name);
            CHECK(text.find(name) != std::string::npos);
        }
        CHECK(text.find("secret") == std::string::npos);
        CHECK(text.find("hidden-command") == std::string::npos);
    }

    TEST_CASE("manPage: a reader sees names, values, defaults and texts as they were given") {
        int status = 0;
        const std::string text = rendered(pageOf(), status);
        REQUIRE(status == 0);
        for (const char* expected :
             {"sample-tool - Turns a thing into [another: thing]", "Where it is: 'here' or \\there",
              "-o, --out PATH", "--pack draco|none|NUMBER|XxYxZ", "--mode fast|exact",
              "--timeout SECONDS", "At what time (one of now, later)", "range: 0.5 - 9; default: 1",
              "environment: SAMPLE_SERVER", "First paragraph of two lines.",
              ".Not a request, \\n either.", "sample-tool convert 'a b' --out -",
              "other-tool(1), man(7)", "~/.config/sample", "sample-tool jobs fetch [OPTIONS] ID",
              "sample-tool convert [OPTIONS] IN ..."}) {
            CAPTURE(expected);
            CHECK(text.find(expected) != std::string::npos);
        }
        CHECK(text.find("Never shown") == std::string::npos);
    }

    TEST_CASE("manPage: what all commands have is told once") {
        int status = 0;
        const std::string text = rendered(pageOf(), status);
        REQUIRE(status == 0);
        const std::size_t first = text.find("-h, --help");
        REQUIRE(first != std::string::npos);
        CHECK(text.find("-h, --help", first + 1) == std::string::npos);
    }

    TEST_CASE("manPage: man has nothing to complain about" * doctest::skip(!isInstalled("man"))) {
        CHECK(complaints("man --warnings -E UTF-8 -l -Tutf8 -Z", " >/dev/null") == "");
    }

    TEST_CASE("manPage: mandoc has nothing to complain about" *
              doctest::skip(!isInstalled("mandoc"))) {
        CHECK(complaints("mandoc -T lint -W warning", "") == "");
    }
}
