#include "client/progress.h"

#include <doctest/doctest.h>

#include <sstream>
#include <thread>
#include <vector>

namespace rivage::client {
namespace {

/// A terminal that understands what the board writes, and nothing else.
class Screen {
public:
    explicit Screen(const std::string& text) {
        for (std::size_t i = 0; i < text.size();) {
            if (text[i] == '\x1b')
                i = control(text, i + 2);
            else
                plain(text[i++]);
        }
    }
    std::vector<std::string> rows{""};

private:
    void plain(char c) {
        if (c == '\n') {
            if (++row_ == rows.size()) rows.emplace_back();
            column_ = 0;
        } else if (c == '\r') {
            column_ = 0;
        } else {
            rows[row_].resize(std::max(rows[row_].size(), column_ + 1), ' ');
            rows[row_][column_++] = c;
        }
    }
    std::size_t control(const std::string& text, std::size_t i) {
        std::size_t number = 0;
        while (text[i] >= '0' && text[i] <= '9')
            number = 10 * number + static_cast<std::size_t>(text[i++] - '0');
        REQUIRE((text[i] == 'A' || text[i] == 'J' || text[i] == 'm'));
        if (text[i] == 'A') {
            REQUIRE(row_ >= number);
            row_ -= number;
        }
        if (text[i] == 'J') {
            rows.resize(row_ + 1);
            rows[row_].resize(std::min(rows[row_].size(), column_));
        }
        return i + 1;
    }
    std::size_t row_ = 0;
    std::size_t column_ = 0;
};

struct Terminal {
    std::istringstream in;
    std::ostringstream out;
    std::ostringstream err;
    Console console{in, out, err, false, true, 60, 10};
};

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("progress: a bar with stage, percent and energy, gone at its end") {
    Terminal terminal;
    {
        ProgressBoard board(terminal.console, false, 1);
        const std::size_t line = board.begin("house.vox");
        board.update(line, {.state = "running",
                            .stage = "solve",
                            .fraction = 0.42,
                            .queuePosition = {},
                            .energy = 1234.5678,
                            .step = 3});
        const Screen screen(terminal.err.str());
        REQUIRE(screen.rows.size() == 1);
        CHECK(screen.rows[0].starts_with("house.vox ["));
        CHECK(screen.rows[0].find(" 42 % solve, energy 1234.6 ") != std::string::npos);
        CHECK(screen.rows[0].size() < 60);
        board.end(line);
        board.say(terminal.err, "house.vox -> house.glb\n");
    }
    CHECK(Screen(terminal.err.str()).rows ==
          std::vector<std::string>{"house.vox -> house.glb", ""});
}

TEST_CASE("progress: a long path leaves room for the bar, which keeps its width") {
    Terminal terminal;
    terminal.console.width = 80;
    ProgressBoard board(terminal.console, false, 1);
    const std::size_t line = board.begin("/a/very/long/path/to/the/models/of/a/game/house.vox");
    std::vector<std::size_t> ends;
    for (const double energy : {1.0, 123456.0}) {
        board.update(line, {.state = "running",
                            .stage = "solve",
                            .fraction = 0.5,
                            .queuePosition = {},
                            .energy = energy,
                            .step = 4});
        const Screen screen(terminal.err.str());
        REQUIRE(screen.rows.size() == 1);
        CHECK(screen.rows[0].starts_with("..."));
        CHECK(screen.rows[0].find("game/house.vox [") != std::string::npos);
        ends.push_back(screen.rows[0].find(']'));
        CHECK(screen.rows[0].size() < 80);
    }
    CHECK(ends[0] != std::string::npos);
    CHECK(ends[0] == ends[1]);
}

TEST_CASE("progress: what is said stays above the bars of several files") {
    Terminal terminal;
    {
        ProgressBoard board(terminal.console, false, 3);
        const std::size_t a = board.begin("a.vox");
        const std::size_t b = board.begin("b.vox");
        board.update(b, {.state = "queued", .stage = "", .fraction = 0, .queuePosition = 4});
        board.end(a);
        board.say(terminal.err, "a is done\n");
        const Screen screen(terminal.err.str());
        REQUIRE(screen.rows.size() == 3);
        CHECK(screen.rows[0] == "a is done");
        CHECK(screen.rows[1] == "1 of 3 done");
        CHECK(screen.rows[2].find("b.vox") == 0);
        CHECK(screen.rows[2].find("queued behind 4") != std::string::npos);
    }
    CHECK(Screen(terminal.err.str()).rows == std::vector<std::string>{"a is done", ""});
}

TEST_CASE("progress: threads do not garble it, and no more lines than there is room") {
    Terminal terminal;
    ProgressBoard board(terminal.console, false, 100);
    std::vector<std::thread> threads;
    for (int t = 0; t < 20; ++t)
        threads.emplace_back([&, t] {
            const std::string name = "file" + std::to_string(t);
            const std::size_t line = board.begin(name);
            for (int i = 0; i < 20; ++i)
                board.update(line, {.state = "running", .stage = "mesh", .fraction = 0.05 * i});
            board.end(line);
            board.say(terminal.err, name + " done\n");
        });
    for (std::thread& thread : threads) thread.join();
    const Screen screen(terminal.err.str());
    CHECK(screen.rows.size() == 21);
    for (std::size_t i = 0; i < 20; ++i) CHECK(screen.rows[i].ends_with(" done"));
}

TEST_CASE("progress: nothing is drawn where there is no terminal, and no colours by default") {
    Terminal terminal;
    terminal.console.errIsTerminal = false;
    ProgressBoard board(terminal.console, false, 2);
    board.update(board.begin("a"), {.state = "running", .stage = "solve", .fraction = 0.5});
    CHECK(terminal.err.str().empty());
    CHECK(painted(terminal.console, Tone::bad, "x") == "x");
    terminal.console.color = true;
    CHECK(painted(terminal.console, Tone::bad, "x") == "\x1b[31mx\x1b[0m");
}

TEST_CASE("progress: bytes for a person") {
    CHECK(bytesText(812) == "812 B");
    CHECK(bytesText(93'100) == "93.1 kB");
    CHECK(bytesText(4'200'000) == "4.2 MB");
}

TEST_SUITE_END();

}  // namespace rivage::client
