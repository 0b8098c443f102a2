#include <doctest/doctest.h>
#include <zlib.h>

#include <map>
#include <sstream>
#include <string>

#include "core/formats/write_nrrd.h"
#include "tests/support/grids.h"

using namespace rivage::test;

namespace {

/// An NRRD file as its text says, read without our code.
struct Nrrd {
    std::map<std::string, std::string> fields;  ///< "key" and "key:=" alike
    std::string data;
};

std::string inflated(const std::string& packed) {
    z_stream stream{};
    REQUIRE(inflateInit2(&stream, 15 + 16) == Z_OK);
    std::string out(1 << 24, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    CHECK(inflate(&stream, Z_FINISH) == Z_STREAM_END);
    CHECK(stream.avail_in == 0);
    out.resize(stream.total_out);
    inflateEnd(&stream);
    return out;
}

Nrrd parse(const std::vector<std::byte>& bytes) {
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::size_t end = text.find("\n\n");
    REQUIRE(end != std::string::npos);
    Nrrd nrrd{{}, text.substr(end + 2)};
    std::istringstream lines(text.substr(0, end));
    std::string line;
    std::getline(lines, line);
    CHECK(line == "NRRD0005");
    while (std::getline(lines, line)) {
        if (line.starts_with('#')) continue;
        const std::size_t colon = line.find(':');
        REQUIRE(colon != std::string::npos);
        const bool isFree = line[colon + 1] == '=';
        const std::size_t value = colon + 2;
        if (!isFree) CHECK(line[colon + 1] == ' ');
        CHECK(nrrd.fields.emplace(line.substr(0, colon), line.substr(value)).second);
    }
    if (nrrd.fields["encoding"] == "gzip") nrrd.data = inflated(nrrd.data);
    return nrrd;
}

}  // namespace

TEST_SUITE("core/formats") {
    TEST_CASE("nrrd: labels, sides, place and segments, packed and raw") {
        VoxelGrid grid = randomGrid(4, {7, 5, 3}, 3);
        grid.labels[Label{1}] = "sea";
        grid.labels[Label{2}] = "line\nbreak\\";
        grid.materials[MaterialId{1}].color = {51, 102, 255, 255};
        const VolumePlace place{{100, 250, 125}, {-1.5, 0, 12.25}};
        for (const bool packed : {true, false}) {
            const auto bytes = writeNrrd(grid, place, packed, {});
            REQUIRE(bytes);
            Nrrd nrrd = parse(*bytes);
            CHECK(nrrd.fields["type"] == "uint8");
            CHECK(nrrd.fields["dimension"] == "3");
            CHECK(nrrd.fields["sizes"] == "7 5 3");
            CHECK(nrrd.fields["encoding"] == (packed ? "gzip" : "raw"));
            CHECK(nrrd.fields["space directions"] == "(100,0,0) (0,250,0) (0,0,125)");
            CHECK(nrrd.fields["space origin"] == "(-1.5,0,12.25)");
            CHECK(nrrd.fields["Segment0_Name"] == "sea");
            CHECK(nrrd.fields["Segment0_LabelValue"] == "1");
            CHECK(nrrd.fields["Segment0_Color"] == "0.2 0.4 1");
            CHECK(nrrd.fields["Segment0_Extent"] == "0 6 0 4 0 2");
            CHECK(nrrd.fields["Segment1_Name"] == "line\\nbreak\\\\");
            CHECK(nrrd.fields.count("Segment2_Layer") == 1);
            CHECK(nrrd.fields.count("Segment3_Name") == 0);
            REQUIRE(nrrd.data.size() == 105);
            for (int i = 0; i < 105; ++i)
                CHECK(static_cast<int>(nrrd.data[i]) ==
                      index(grid.labelAt({i % 7, i / 7 % 5, i / 35})));
        }
    }

    TEST_CASE("nrrd: above 255 labels values have two bytes") {
        const VoxelGrid grid = randomGrid(4, {20, 20, 20}, 300);
        const auto bytes = writeNrrd(grid, {}, true, {});
        REQUIRE(bytes);
        Nrrd nrrd = parse(*bytes);
        CHECK(nrrd.fields["type"] == "uint16");
        CHECK(nrrd.fields["endian"] == "little");
        REQUIRE(nrrd.data.size() == 16000);
        for (int i = 0; i < 8000; ++i) {
            const auto byte = [&](int at) { return static_cast<unsigned char>(nrrd.data[at]); };
            REQUIRE(byte(2 * i) + 256 * byte(2 * i + 1) ==
                    index(grid.labelAt({i % 20, i / 20 % 20, i / 400})));
        }
    }

    TEST_CASE("determinism: the same bytes again") {
        const VoxelGrid grid = ballGrid(30, 12);
        CHECK(*writeNrrd(grid, {}, true, {}) == *writeNrrd(grid, {}, true, {}));
    }

    TEST_CASE("reject: a volume above the limit, and a stop") {
        RunContext run;
        run.limits.maxOutputBytes = 999;
        const auto bytes = writeNrrd(ballGrid(10, 4), {}, true, run);
        REQUIRE_FALSE(bytes);
        CHECK(bytes.error().code == ErrorCode::outputTooLarge);
        CHECK(bytes.error().actual == 1000);
        CHECK_FALSE(writeNrrd(ballGrid(10, 4), {}, true, {.stopRequested = [] { return true; }}));
    }
}
