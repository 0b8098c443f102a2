// The server program with the fake engine: for tests and drivers that need jobs of a known length,
// and crashes.
#include "server/run.h"
#include "tests/server/fake_engine.h"

int main(int argc, char** argv) {
    rivage::test::Gate gate;
    return rivage::server::runServer(argc, argv, rivage::test::fakeEngine(gate),
                                     rivage::test::fakeSamples());
}
