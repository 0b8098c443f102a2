#include "core/surface/split_umbrellas.h"

#include <algorithm>
#include <string>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

constexpr int kMaxAround = 12;  // surfels around a pointel

PointelId pointel(std::size_t i) { return PointelId{static_cast<std::uint32_t>(i)}; }
SurfelId surfel(std::size_t i) { return SurfelId{static_cast<std::uint32_t>(i)}; }

/// The surfels around one pointel, ascending.
struct Around {
    struct Item {
        SurfelId surfel;
        std::uint8_t corner;  ///< at which it has the pointel
    };
    std::array<Item, kMaxAround> items{};
    int count = 0;

    Around(const DigitalSurface& surface, PointelId p) {
        const auto next = [&](PointelId from, int axis) {
            return from == kNone<PointelId> ? from : surface.neighbours[from][2 * axis];
        };
        for (int axis = 0; axis < 3; ++axis) {
            const int b = (axis + 1) % 3;
            const int c = (axis + 2) % 3;
            const PointelId left = next(p, b);
            for (const PointelId lowest : {p, left, next(p, c), next(left, c)})
                add(surface, surface.surfelAt(lowest, axis), p);
        }
        std::sort(items.begin(), items.begin() + count,
                  [](const Item& i, const Item& j) { return i.surfel < j.surfel; });
    }

private:
    void add(const DigitalSurface& surface, SurfelId s, PointelId p) {
        if (s == kNone<SurfelId>) return;
        const auto& corners = surface.corners[s];
        const auto at = std::find(corners.begin(), corners.end(), p) - corners.begin();
        items[count++] = {s, static_cast<std::uint8_t>(at)};
    }
};

/// The surfels of an `Around` that share the linel to one neighbour, as indices into it, with the
/// edge of each that lies on the linel.
struct OnLinel {
    std::array<std::uint8_t, 4> items{};
    std::array<std::uint8_t, 4> edges{};
    int count = 0;

    OnLinel(const DigitalSurface& surface, const Around& around, PointelId neighbour) {
        for (int i = 0; i < around.count; ++i) {
            const auto& corners = surface.corners[around.items[i].surfel];
            const int k = around.items[i].corner;
            const int before = (k + 3) & 3;
            const bool follows = corners[(k + 1) & 3] == neighbour;
            if (!follows && corners[before] != neighbour) continue;
            items[count] = static_cast<std::uint8_t>(i);
            edges[count++] = static_cast<std::uint8_t>(follows ? k : before);
        }
    }
};

/// The fans of an `Around`, numbered by their first surfels.
class Fans {
public:
    Fans(const DigitalSurface& surface, const SurfelLinks& links, const Around& around,
         PointelId p) {
        for (int i = 0; i < around.count; ++i) root_[i] = static_cast<std::uint8_t>(i);
        for (int slot = 0; slot < kSlots; ++slot) {
            const PointelId neighbour = surface.neighbours[p][slot];
            if (neighbour == kNone<PointelId>) continue;
            const bool junction = surface.junctionSlots[p] >> slot & 1;
            joinAcross(links, around, OnLinel(surface, around, neighbour), junction);
        }
        for (int i = 0; i < around.count; ++i)
            fan_[i] = root_[i] == i ? static_cast<std::uint8_t>(count_++) : fan_[root_[i]];
    }
    [[nodiscard]] int count() const { return count_; }
    [[nodiscard]] int of(int item) const { return fan_[item]; }

private:
    void joinAcross(const SurfelLinks& links, const Around& around, const OnLinel& linel,
                    bool all) {
        for (int i = 0; i < linel.count; ++i)
            all = all ||
                  links[around.items[linel.items[i]].surfel][linel.edges[i]] == kNone<SurfelId>;
        for (int i = 0; i < linel.count; ++i) {
            const SurfelId other = links[around.items[linel.items[i]].surfel][linel.edges[i]];
            for (int j = 0; j < i; ++j)
                if (all || around.items[linel.items[j]].surfel == other)
                    join(linel.items[i], linel.items[j], around.count);
        }
    }
    // The smaller root wins; there are so few that all are renamed at once.
    void join(int i, int j, int size) {
        const std::uint8_t keep = std::min(root_[i], root_[j]);
        const std::uint8_t drop = std::max(root_[i], root_[j]);
        for (int k = 0; k < size; ++k)
            if (root_[k] == drop) root_[k] = keep;
    }

    std::array<std::uint8_t, kMaxAround> root_{};
    std::array<std::uint8_t, kMaxAround> fan_{};
    int count_ = 0;
};

/// Where the copies of each pointel begin; one entry more than there are pointels.
using Starts = std::vector<std::uint64_t>;

bool isAlone(const Starts& starts, PointelId p) {
    return starts[index(p) + 1U] - starts[index(p)] == 1;
}

bool countFans(const DigitalSurface& surface, const SurfelLinks& links, const RunContext& run,
               Starts& starts) {
    // Two fans have three linels each, and a surfel lies in one of them: with fewer than five
    // linels in all there is no room for the second.
    constexpr int kFewestLinels = 5;
    const bool done = parallelFor(surface.pointelCount(), run, [&](std::size_t i) {
        const auto& slots = surface.neighbours[pointel(i)];
        const auto empty = std::count(slots.begin(), slots.end(), kNone<PointelId>);
        starts[i + 1] = 1;
        if (kSlots - empty < kFewestLinels) return;
        const Around around(surface, pointel(i));
        starts[i + 1] =
            static_cast<std::uint64_t>(Fans(surface, links, around, pointel(i)).count());
    });
    return done && serialFor(surface.pointelCount(), run,
                             [&](std::size_t i) { starts[i + 1] += starts[i]; });
}

/// Everything of the split surface that belongs to pointels, and the new corners.
struct Pieces {
    IdVector<PointelId, Vec3i> pointels;
    IdVector<PointelId, std::array<PointelId, kSlots>> neighbours;
    IdVector<PointelId, std::uint8_t> junctionSlots;
    IdVector<PointelId, std::uint8_t> fixedAxes;
    IdVector<SurfelId, std::array<PointelId, 4>> corners;
};

bool fillCorners(const DigitalSurface& surface, const SurfelLinks& links, const Starts& starts,
                 const RunContext& run, Pieces& pieces) {
    pieces.corners = surface.corners;
    const bool renamed = parallelFor(surface.surfelCount(), run, [&](std::size_t i) {
        for (PointelId& p : pieces.corners[surfel(i)]) p = pointel(starts[index(p)]);
    });
    return renamed && parallelFor(surface.pointelCount(), run, [&](std::size_t i) {
               const PointelId p = pointel(i);
               if (isAlone(starts, p)) return;
               const Around around(surface, p);
               const Fans fans(surface, links, around, p);
               for (int k = 0; k < around.count; ++k) {
                   const auto [s, corner] = around.items[k];
                   pieces.corners[s][corner] =
                       pointel(starts[i] + static_cast<std::uint64_t>(fans.of(k)));
               }
           });
}

/// The copies of one linel, seen from the low or the high end alike: see `splitUmbrellas`.
void linkCopies(const DigitalSurface& surface, const Around& around, PointelId p, int slot,
                Pieces& pieces) {
    const OnLinel linel(surface, around, surface.neighbours[p][slot]);
    std::array<PointelId, 4> own{};
    std::array<PointelId, 4> other{};
    for (int i = 0; i < linel.count; ++i) {
        const auto [s, corner] = around.items[linel.items[i]];
        const int edge = linel.edges[i];
        own[i] = pieces.corners[s][corner];
        other[i] = pieces.corners[s][edge == corner ? (edge + 1) & 3 : edge];
    }
    for (int i = 0; i < linel.count; ++i) {
        bool paired = true;
        for (int j = 0; j < linel.count; ++j)
            paired = paired && (own[j] == own[i]) == (other[j] == other[i]);
        if (!paired) continue;
        pieces.neighbours[own[i]][slot] = other[i];
        pieces.junctionSlots[own[i]] |=
            static_cast<std::uint8_t>(surface.junctionSlots[p] & 1U << slot);
    }
}

void fillPointel(const DigitalSurface& surface, const Starts& starts, PointelId p, Pieces& pieces) {
    bool simple = isAlone(starts, p);
    for (const PointelId q : surface.neighbours[p])
        simple = simple && (q == kNone<PointelId> || isAlone(starts, q));
    for (std::uint64_t i = starts[index(p)]; i < starts[index(p) + 1U]; ++i) {
        pieces.pointels[pointel(i)] = surface.pointels[p];
        if (!surface.fixedAxes.empty()) pieces.fixedAxes[pointel(i)] = surface.fixedAxes[p];
    }
    const PointelId first = pointel(starts[index(p)]);
    if (simple) pieces.junctionSlots[first] = surface.junctionSlots[p];
    if (simple) {
        for (int slot = 0; slot < kSlots; ++slot)
            if (const PointelId q = surface.neighbours[p][slot]; q != kNone<PointelId>)
                pieces.neighbours[first][slot] = pointel(starts[index(q)]);
        return;
    }
    const Around around(surface, p);
    for (int slot = 0; slot < kSlots; ++slot)
        if (surface.neighbours[p][slot] != kNone<PointelId>)
            linkCopies(surface, around, p, slot, pieces);
}

void replace(DigitalSurface& surface, Pieces pieces) {
    surface.pointels = std::move(pieces.pointels);
    surface.neighbours = std::move(pieces.neighbours);
    surface.junctionSlots = std::move(pieces.junctionSlots);
    surface.fixedAxes = std::move(pieces.fixedAxes);
    surface.corners = std::move(pieces.corners);
}

}  // namespace

Result<std::size_t> splitUmbrellas(DigitalSurface& surface, const SurfelLinks& links,
                                   const RunContext& run) {
    const std::size_t before = surface.pointelCount();
    Starts starts(before + 1);
    if (!countFans(surface, links, run, starts)) return fail(run.stopError());
    constexpr std::uint64_t kMaxCells = 0xfffffffe;  // the last id means "none"
    if (starts.back() > kMaxCells)
        return fail(Error{ErrorCode::tooLarge,
                          "the digital surface has " + std::to_string(starts.back()) + " cells",
                          "/grid", kMaxCells, starts.back()});
    std::size_t split = 0;
    serialFor(before, run, [&](std::size_t i) { split += isAlone(starts, pointel(i)) ? 0 : 1; });
    if (split > 0) {
        Pieces pieces;
        if (!fillCorners(surface, links, starts, run, pieces)) return fail(run.stopError());
        std::array<PointelId, kSlots> noNeighbours;
        noNeighbours.fill(kNone<PointelId>);
        pieces.pointels.resize(starts.back(), Vec3i::Zero());
        pieces.neighbours.resize(starts.back(), noNeighbours);
        pieces.junctionSlots.resize(starts.back());
        pieces.fixedAxes.resize(surface.fixedAxes.empty() ? 0 : starts.back());
        const bool filled = parallelFor(
            before, run, [&](std::size_t i) { fillPointel(surface, starts, pointel(i), pieces); });
        if (!filled) return fail(run.stopError());
        replace(surface, std::move(pieces));
    }
    if (run.stopped()) return fail(run.stopError());
    surface.firstSurfel = {};
    surface.surfelAxes = {};
    return split;
}

}  // namespace rivage::core
