#include "core/solve/preconditioner.h"

#include "core/solve/float_sums.h"

namespace rivage::core {

Preconditioner::Preconditioner(const Energy& energy, const FloatOperator& operation,
                               CoarseLevels* coarse)
    : workers_(energy.workers()),
      coarse_(coarse != nullptr && coarse->any() ? coarse : nullptr),
      blocks_(operation.diagonalBlocks()),
      inverses_(energy.size(), Symmetric3{}),
      free_(energy.size(), Float4{}),
      local_(energy.size()) {}

void Preconditioner::setFree(const FloatVectors& free) {
    forEachLanes(free_.size(), workers_, [&](std::size_t i) {
        const Lanes mask = free.raw()[i].lanes;
        if (!anyLane(mask != free_.raw()[i].lanes)) return;
        free_.raw()[i].lanes = mask;
        const Symmetric3& block = blocks_.raw()[i];
        inverses_.raw()[i] = inverseOf({block.diagonal * mask + (Lanes{1, 1, 1, 1} - mask),
                                        block.beside * mask * turned(mask)});
        inverses_.raw()[i].diagonal *= mask;
    });
}

double Preconditioner::apply(const FloatVectors& r) {
    const double local = sumLanes(local_.size(), workers_, [&](std::size_t i) {
        const Lanes here = r.raw()[i].lanes;
        const Lanes z = product(inverses_.raw()[i], here);
        local_.raw()[i].lanes = z;
        return here * z;
    });
    return coarse_ == nullptr ? local : local + coarse_->solve(r);
}

}  // namespace rivage::core
