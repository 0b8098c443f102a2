#include <doctest/doctest.h>

#include "core/voxelize/windings.h"
#include "tests/core/voxelize/voxelize_fixtures.h"

using namespace rivage::test;

TEST_SUITE("core/voxelize") {
    TEST_CASE("windings: the sum is 1, whatever is passed") {
        Windings windings(Label{0});
        CHECK(windings.only() == Label{0});
        windings.pass(Label{1}, Label{2});
        CHECK(windings.sum() == 1);
        CHECK_FALSE(windings.only());
        CHECK(windings.most() == std::vector<Label>{Label{0}, Label{2}});
        windings.pass(Label{0}, Label{1});
        CHECK(windings.only() == Label{2});
    }
}
