#include "core/base/options.h"

namespace rivage::core {

MethodOptions presetOptions(Preset preset) {
    MethodOptions options;  // the defaults are `studio`
    switch (preset) {
        case Preset::studio: break;
        case Preset::paper:
            options.normals.method = NormalMethod::integralInvariant;
            options.energy = {.alpha = 0.001,
                              .beta = 1,
                              .gamma = 0.05,
                              .fairness = Fairness::umbrella,
                              .junctionFairness = JunctionFairness::umbrella,
                              .split = false};
            options.solve.displacementLimit = std::nullopt;
            options.solve.untangle = false;
            break;
        case Preset::organic: options.normals.method = NormalMethod::convolved; break;
        case Preset::architectural:
            options.normals.method = NormalMethod::discVote;
            options.energy.alpha = 0.05;
            break;
        case Preset::noisy:
            // Flipped voxels stand out by a whole voxel, so vertices have to move further.
            options.normals.method = NormalMethod::robust;
            options.solve.displacementLimit = 1.5;
            break;
    }
    return options;
}

}  // namespace rivage::core
