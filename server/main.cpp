#include "server/ops/engine.h"
#include "server/run.h"

int main(int argc, char** argv) {
    using namespace rivage::server;
    return runServer(argc, argv, coreEngine(), coreSamples());
}
