#include "core/base/options.h"

namespace rivage::core {

MethodOptions presetOptions(Preset preset) {
    MethodOptions options;  // the defaults are `studio`
    switch (preset) {
        case Preset::studio: break;
        case Preset::paper:
            options.normals = {.method = NormalMethod::integralInvariant, .radius = 3};
            options.energy = {.alpha = 0.001,
                              .beta = 1,
                              .gamma = 0.05,
                              .fairness = Fairness::umbrella,
                              .junctionFairness = JunctionFairness::umbrella};
            options.solve.displacementLimit = std::nullopt;
            options.solve.untangle = false;
            break;
    }
    return options;
}

}  // namespace rivage::core
