#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace rivage::core {

/// The stages of a conversion, in their order. `stageName` gives the name of the wire.
enum class Stage : std::uint8_t { parse, surface, normals, solve, emboss, mesh, write };
inline constexpr std::size_t kStageCount = 7;
[[nodiscard]] constexpr const char* stageName(Stage stage) {
    constexpr const char* kNames[kStageCount] = {"parse",  "surface", "normals", "solve",
                                                 "emboss", "mesh",    "write"};
    return kNames[static_cast<std::size_t>(stage)];
}

/// Limits of one conversion, each checked before the allocation that it bounds.
struct Limits {
    std::uint64_t maxInputBytes = 64ULL << 20;  ///< stored or inflated
    std::uint64_t maxVoxels = 1ULL << 28;       ///< non-empty voxels after merging
    std::uint64_t maxExtent = 4096;             ///< longest side of the merged grid, voxels
    std::uint64_t maxMaterials = 65535;         ///< distinct materials
    std::uint64_t maxLabels = 4096;             ///< distinct labels, background not counted
    std::uint64_t maxModels = 65536;            ///< models and instances of a scene, each
    std::uint64_t maxMemory = 8ULL << 30;       ///< predicted bytes of one conversion
    std::uint64_t maxOutputBytes = 1ULL << 30;  ///< bytes of the artifact
};

/// The artifact of an intermediate state of the solver.
struct Preview {
    int step = 0;       ///< of the solver: 0 is the voxel surface itself, then 1, 4, 16, ...
    double energy = 0;  ///< of the surface shown
    std::vector<std::byte> bytes;
    std::string mediaType;
};

/// What every stage gets beside its data: threads, limits, and the ways to stop and to watch it.
/// The callbacks must be cheap and must not throw; `progress`, `energy` and `preview` are called
/// from one thread at a time, `stopRequested` from all threads of a stage, every few milliseconds at least.
struct RunContext {
    int threads = 1;
    Limits limits = {};
    /// Polled inside every long loop: true asks the stage to give up, and stays true.
    std::function<bool()> stopRequested = {};
    /// Set beside `stopRequested`: whether the stop was asked for by the clock or by a person.
    std::function<ErrorCode()> stopReason = {};
    /// A stage begins (`fraction` 0) or has done `fraction` of its work.
    std::function<void(Stage, double fraction)> progress = {};
    /// The energy at steps 0, 1, 4, 16, ... of the solver; 0 is the voxel surface itself.
    std::function<void(int step, double energy)> energy = {};
    /// Set if previews are wanted; they change nothing in the result.
    std::function<void(Preview)> preview = {};

    [[nodiscard]] bool stopped() const { return stopRequested && stopRequested(); }
    void report(Stage stage, double fraction) const {
        if (progress) progress(stage, fraction);
    }
    /// The error of a stage that gave up because `stopped()`.
    [[nodiscard]] Error stopError() const {
        const ErrorCode code = stopReason ? stopReason() : ErrorCode::cancelled;
        return {code, code == ErrorCode::timedOut ? "the deadline of this conversion passed"
                                                  : "the conversion was cancelled"};
    }
    /// For a part of a stage: what it reports from 0 to 1 is `from` to `to` of the stage.
    [[nodiscard]] RunContext part(double from, double to) const {
        RunContext context = *this;
        if (progress)
            context.progress = [whole = progress, from, to](Stage stage, double fraction) {
                whole(stage, from + (to - from) * fraction);
            };
        return context;
    }
};

}  // namespace rivage::core
