#include <cstdio>
#include <cstdlib>
#include "tests/study/sections.h"
using namespace rivage::study;
int main(int argc, char** argv) {
    Scale s;
    s.threads = 2;
    s.poses = argc > 2 ? atoi(argv[2]) : 2;
    s.resolution = 32;
    s.largest = argc > 3 ? atoi(argv[3]) : 64;
    auto r = runSection(argv[1], s);
    writeSamples("/tmp/h-study", argv[1], r);
}
