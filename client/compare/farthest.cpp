#include "client/compare/farthest.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "client/compare/blocks.h"

namespace rivage::client {
namespace {

using Eigen::Vector3d;
using Search = TriangleTree::Search;

/// A part of a triangle of A, and how far its points can be from B.
struct Piece {
    Triangle corners;
    double atMost = 0;
};

bool isNearer(const Piece& x, const Piece& y) { return x.atMost < y.atMost; }

class Bounds {
public:
    Bounds(const Surface& b, const TriangleTree& tree, const FarthestSettings& settings)
        : b_(b), tree_(tree), settings_(settings) {}

    /// Bounds the distances of a piece, and takes its middle as a candidate.
    void look(Piece& piece, Farthest& found) {
        const Triangle& corners = piece.corners;
        const Vector3d middle = (corners[0] + corners[1] + corners[2]) / 3;
        tree_.closest(middle, search_);
        const double distance = withoutRounding(std::sqrt(search_.distance2));
        if (distance > found.distance) {
            found.distance = distance;
            found.at = middle;
        }
        piece.atMost = std::numeric_limits<double>::infinity();
        for (const Search::Tie& tie : search_.ties)
            piece.atMost = std::min(piece.atMost, farthestCorner(corners, tie.triangle));
    }

    /// Whether a bound is as good as what has been found.
    [[nodiscard]] bool isEnough(double atMost, const Farthest& found) const {
        return atMost <= std::max(found.distance * (1 + settings_.enough), settings_.zero);
    }

    /// Cuts a piece until its bound is enough; the farthest of its parts first.
    void refine(const Piece& whole, std::size_t searches, Farthest& found) {
        std::vector<Piece> heap{whole};
        while (searches >= 4 && !isEnough(heap.front().atMost, found)) {
            std::pop_heap(heap.begin(), heap.end(), isNearer);
            const Triangle t = heap.back().corners;
            heap.pop_back();
            const Triangle m{(t[1] + t[2]) / 2, (t[2] + t[0]) / 2, (t[0] + t[1]) / 2};
            for (const Triangle& part : {Triangle{t[0], m[2], m[1]}, Triangle{m[2], t[1], m[0]},
                                         Triangle{m[1], m[0], t[2]}, m}) {
                heap.push_back({part});
                look(heap.back(), found);
                std::push_heap(heap.begin(), heap.end(), isNearer);
            }
            searches -= 4;
        }
        found.atMost = std::max(found.distance, heap.front().atMost);
    }

private:
    [[nodiscard]] double farthestCorner(const Triangle& corners, std::uint32_t triangle) const {
        const Triangle other = cornersOf(b_, triangle);
        double distance2 = 0;
        for (const Vector3d& corner : corners)
            distance2 =
                std::max(distance2, (closestOnTriangle(corner, other) - corner).squaredNorm());
        return withoutRounding(std::sqrt(distance2));
    }

    [[nodiscard]] double withoutRounding(double distance) const {
        return distance <= settings_.zero ? 0 : distance;
    }

    const Surface& b_;
    const TriangleTree& tree_;
    const FarthestSettings& settings_;
    Search search_;
};

/// The farther of two, and the first of equals.
void merge(const Farthest& one, Farthest& best) {
    if (one.distance > best.distance) {
        best.distance = one.distance;
        best.at = one.at;
    }
    best.atMost = std::max(best.atMost, one.atMost);
}

}  // namespace

Farthest findFarthest(const Surface& a, const std::vector<std::uint32_t>& triangles,
                      const Surface& b, const TriangleTree& tree, const Farthest& known,
                      const FarthestSettings& settings) {
    std::vector<double> atMost(triangles.size());
    std::vector<Farthest> middles(triangles.size());
    forBlocks(triangles.size(), settings.threads, [&](std::size_t from, std::size_t to) {
        Bounds bounds(b, tree, settings);
        for (std::size_t i = from; i < to; ++i) {
            Piece piece{cornersOf(a, triangles[i])};
            bounds.look(piece, middles[i]);
            atMost[i] = piece.atMost;
        }
    });
    Farthest best = known;
    for (const Farthest& middle : middles) merge(middle, best);

    const Bounds judge(b, tree, settings);
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (judge.isEnough(atMost[i], best))
            best.atMost = std::max(best.atMost, atMost[i]);
        else
            open.push_back(i);
    }
    // Each starts from the same guess, whatever the others find meanwhile: the answer is the same
    // in any order.
    std::vector<Farthest> found(open.size(), best);
    const std::size_t searches = settings.searches / std::max<std::size_t>(1, open.size());
    forBlocks(
        open.size(), settings.threads,
        [&](std::size_t from, std::size_t to) {
            Bounds bounds(b, tree, settings);
            for (std::size_t i = from; i < to; ++i)
                bounds.refine({cornersOf(a, triangles[open[i]]), atMost[open[i]]}, searches,
                              found[i]);
        },
        8);
    for (const Farthest& one : found) merge(one, best);
    best.atMost = std::max(best.atMost, best.distance);
    return best;
}

}  // namespace rivage::client
