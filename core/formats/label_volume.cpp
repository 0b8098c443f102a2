#include "core/formats/label_volume.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace rivage::core {
namespace {

constexpr std::uint32_t kSmallValues = 65536;  // looked up in a table, larger ones in a map
constexpr std::size_t kPoll = 1 << 16;         // values between two polls
constexpr int kPollRows = 64;
// The store of a brick grid doubles when it is full, so up to twice its bricks are reserved.
constexpr std::uint64_t kStoreSlack = 2;

/// A number as a whole one of 32 bits, if it is one.
std::optional<std::uint32_t> wholeIn(double value) {
    const bool fits = value >= 0 && value <= std::numeric_limits<std::uint32_t>::max();
    return fits && value == std::floor(value) ? std::optional(static_cast<std::uint32_t>(value))
                                              : std::nullopt;
}

/// The stored value; nothing if it is no whole number from 0 on that fits 32 bits.
std::optional<std::uint32_t> valueAt(const std::byte* bytes, const ValueType& type) {
    std::uint64_t raw = 0;
    for (int i = 0; i < type.bytes; ++i) {
        const int at = type.bigEndian ? i : type.bytes - 1 - i;
        raw = raw << 8 | std::to_integer<std::uint64_t>(bytes[at]);
    }
    if (type.isBoolean) return raw != 0 ? 1 : 0;
    if (type.isFloat)
        return wholeIn(type.bytes == 4 ? std::bit_cast<float>(static_cast<std::uint32_t>(raw))
                                       : std::bit_cast<double>(raw));
    const bool negative = type.isSigned && (raw >> (8 * type.bytes - 1) & 1) != 0;
    if (negative || raw > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
    return static_cast<std::uint32_t>(raw);
}

/// Which values occur, and later which material each of them is.
class ValueTable {
public:
    /// @return how many distinct values but 0 occurred so far
    std::size_t add(std::uint32_t value) {
        if (value < kSmallValues) {
            if (value != 0 && small_[value] == MaterialId{0}) {
                small_[value] = MaterialId{1};
                ++count_;
            }
        } else if (large_.emplace(value, MaterialId{1}).second) {
            ++count_;
        }
        return count_;
    }
    /// Numbers the values in ascending order.
    IdVector<MaterialId, Material> number() {
        IdVector<MaterialId, Material> materials(1);
        const auto next = [&](std::uint32_t value) {
            return materials.push_back({.source = value, .color = valueColor(value)});
        };
        for (std::uint32_t value = 1; value < kSmallValues; ++value)
            if (small_[value] != MaterialId{0}) small_[value] = next(value);
        for (auto& [value, material] : large_) material = next(value);
        return materials;
    }
    [[nodiscard]] MaterialId materialOf(std::uint32_t value) const {
        return value < kSmallValues ? small_[value] : large_.at(value);
    }

private:
    std::vector<MaterialId> small_ = std::vector<MaterialId>(kSmallValues, MaterialId{0});
    std::map<std::uint32_t, MaterialId> large_;
    std::size_t count_ = 0;
};

std::string sizeText(const Vec3i& size) {
    return std::to_string(size.x()) + "x" + std::to_string(size.y()) + "x" +
           std::to_string(size.z());
}

Result<ValueTable> collectValues(std::span<const std::byte> values, const ValueType& type,
                                 const RunContext& run) {
    const std::size_t pollBytes = std::size_t{kPoll} * type.bytes;
    const std::uint64_t limit = std::min<std::uint64_t>(run.limits.maxMaterials, 0xffff);
    ValueTable table;
    for (std::size_t offset = 0; offset < values.size(); offset += type.bytes) {
        if (offset % pollBytes == 0 && run.stopped()) return fail(run.stopError());
        const std::optional<std::uint32_t> value = valueAt(values.data() + offset, type);
        if (!value)
            return fail(ErrorCode::malformedInput,
                        "the value at index " + std::to_string(offset / type.bytes) +
                            " is no whole number from 0 to 4294967295, so it is no label",
                        "/grid");
        if (const std::size_t distinct = table.add(*value); distinct > limit)
            return fail(
                Error{ErrorCode::tooManyLabels,
                      "the grid has more than " + std::to_string(limit) + " distinct values",
                      "/grid", limit, distinct});
    }
    return table;
}

Result<BrickGrid> fillBricks(std::span<const std::byte> values, const ValueType& type,
                             const Vec3i& size, const ValueTable& table, const RunContext& run) {
    BrickGrid grid(size);
    const std::byte* next = values.data();
    for (int z = 0; z < size.z(); ++z) {
        for (int y = 0; y < size.y(); ++y) {
            if (y % kPollRows == 0 && run.stopped()) return fail(run.stopError());
            for (int x = 0; x < size.x(); ++x, next += type.bytes) {
                const std::uint32_t value = valueAt(next, type).value_or(0);
                if (value != 0) grid.set(Vec3i(x, y, z), table.materialOf(value));
            }
        }
    }
    return grid;
}

}  // namespace

std::optional<std::uint64_t> volumeBytes(const Vec3i& size, const ValueType& type) {
    std::uint64_t bytes = static_cast<std::uint64_t>(type.bytes);
    for (int axis = 0; axis < 3; ++axis) {
        const auto side = static_cast<std::uint64_t>(size[axis]);
        if (side != 0 && bytes > (std::uint64_t{1} << 63) / side) return std::nullopt;
        bytes *= side;
    }
    return bytes;
}

Result<std::uint64_t> checkVolumeSize(const Vec3i& size, const ValueType& type,
                                      const Limits& limits, ErrorCode code,
                                      const std::string& field) {
    if ((size.array() < 1).any())
        return fail(code, "the size " + sizeText(size) + " must be at least 1 along each axis",
                    field);
    const std::optional<std::uint64_t> bytes = volumeBytes(size, type);
    if (!bytes || *bytes > limits.maxInputBytes)
        return fail(Error{ErrorCode::tooLarge,
                          "a volume of " + sizeText(size) + " values takes more than " +
                              std::to_string(limits.maxInputBytes) + " bytes",
                          field, limits.maxInputBytes, bytes, "--max-upload"});
    const auto extent = static_cast<std::uint64_t>(size.maxCoeff());
    if (extent > limits.maxExtent)
        return fail(Error{ErrorCode::tooLarge,
                          "the volume " + sizeText(size) + " is more than " +
                              std::to_string(limits.maxExtent) + " voxels long",
                          field, limits.maxExtent, extent, "--max-extent"});
    return *bytes;
}

Result<Scene> sceneFromVolume(std::span<const std::byte> values, const ValueType& type,
                              const Vec3i& size, const RunContext& run) {
    const Vec3i bricks = (size.array() + (BrickGrid::kSide - 1)) / BrickGrid::kSide;
    const std::uint64_t memory = static_cast<std::uint64_t>(bricks.x()) * bricks.y() * bricks.z() *
                                 (sizeof(BrickGrid::Brick) * kStoreSlack + sizeof(std::uint32_t));
    if (memory > run.limits.maxMemory)
        return fail(Error{ErrorCode::memoryBudget,
                          "a grid of " + sizeText(size) + " voxels needs up to " +
                              std::to_string(memory) + " bytes",
                          "/grid", run.limits.maxMemory, memory, "--memory-budget"});
    Result<ValueTable> table = collectValues(values, type, run);
    if (!table) return fail(std::move(table.error()));
    Scene scene;
    scene.materials = table->number();
    if (scene.materials.size() == 1)
        return fail(ErrorCode::emptyGrid, "every value of the volume is 0", "/grid");
    Result<BrickGrid> grid = fillBricks(values, type, size, *table, run);
    if (!grid) return fail(std::move(grid.error()));
    scene.models.push_back(*std::move(grid));
    scene.instances.push_back({.frames = {0}, .centered = false});
    return scene;
}

}  // namespace rivage::core
