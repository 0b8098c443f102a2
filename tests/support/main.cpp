#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <oneapi/tbb/global_control.h>

int main(int argc, char** argv) {
    // The determinism tests run on up to 7 threads, on however small a machine.
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 8);
    return doctest::Context(argc, argv).run();
}
