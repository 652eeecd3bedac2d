#include "reconstruct/pieces.h"

#include <algorithm>
#include <numeric>

namespace pointbake {
namespace {

// Pieces with fewer triangles are leftovers unless more than half of their points lie on no larger
// piece; those with fewer still always are.
constexpr std::size_t kLargePiece = 12, kMinPiece = 4;
// Pieces with at most so many triangles are flakes if most of their points have a Delaunay
// neighbour on a larger piece within so many spacings: most often what is left where two sheets are
// closer than the points of either.
constexpr std::size_t kLargestFlake = 128;
static_assert(kLargestFlake >= kLargePiece);
constexpr double kFlakeReach = 1.5;

class Chooser {
 public:
    Chooser(const Tetrahedra& tets, std::span<const float> spacing)
        : tets_(tets), spacing_(spacing), is_used_(tets.num_real(), 0) {}

    // Leaves each point once.
    bool is_worth(std::size_t num_triangles, std::vector<Index>& points) const {
        if (num_triangles > kLargestFlake) return true;
        std::sort(points.begin(), points.end());
        points.erase(std::unique(points.begin(), points.end()), points.end());
        return !is_leftover(num_triangles, points) && !is_flake(num_triangles, points);
    }

    void keep(const std::vector<Index>& points) {
        for (Index v : points) is_used_[v] = 1;
    }

 private:
    bool is_leftover(std::size_t num_triangles, const std::vector<Index>& points) const {
        if (num_triangles >= kLargePiece) return false;
        const auto num_used =
            std::count_if(points.begin(), points.end(), [&](Index v) { return is_used_[v] != 0; });
        return num_triangles < kMinPiece || 2 * static_cast<std::size_t>(num_used) >= points.size();
    }

    bool is_flake(std::size_t num_triangles, const std::vector<Index>& points) const {
        if (num_triangles > kLargestFlake) return false;
        const auto num_near =
            std::count_if(points.begin(), points.end(), [&](Index v) { return is_near_used(v); });
        return 2 * static_cast<std::size_t>(num_near) > points.size();
    }

    bool is_near_used(Index v) const {
        if (is_used_[v] != 0) return true;
        const double reach = kFlakeReach * spacing_[v];
        for (Index c : tets_.star(v))
            for (Index q : tets_.cells[c])
                if (!tets_.is_far(q) && is_used_[q] != 0 &&
                    squared_length(tets_.points[q] - tets_.points[v]) <= reach * reach)
                    return true;
        return false;
    }

    const Tetrahedra& tets_;
    std::span<const float> spacing_;
    std::vector<std::uint8_t> is_used_;
};

}  // namespace

Pieces find_pieces(std::span<const std::array<Index, 3>> neighbors) {
    Pieces pieces;
    pieces.members.reserve(neighbors.size());
    std::vector<std::uint8_t> seen(neighbors.size(), 0);
    for (Index first = 0; first < neighbors.size(); ++first) {
        if (seen[first] != 0) continue;
        seen[first] = 1;
        pieces.members.push_back(first);
        for (std::size_t head = pieces.begin.back(); head < pieces.members.size(); ++head) {
            for (Index t : neighbors[pieces.members[head]]) {
                if (t == kInvalidIndex || seen[t] != 0) continue;
                seen[t] = 1;
                pieces.members.push_back(t);
            }
        }
        pieces.begin.push_back(static_cast<Index>(pieces.members.size()));
    }
    return pieces;
}

std::vector<std::uint8_t> choose_pieces(const Tetrahedra& tets, std::span<const float> spacing,
                                        std::span<const Triangle> triangles, const Pieces& pieces) {
    std::vector<std::uint32_t> by_size(pieces.size());
    std::iota(by_size.begin(), by_size.end(), 0U);
    std::stable_sort(by_size.begin(), by_size.end(), [&](std::uint32_t p, std::uint32_t q) {
        return pieces.of(p).size() > pieces.of(q).size();
    });
    Chooser chooser(tets, spacing);
    std::vector<std::uint8_t> is_kept(pieces.size(), 0);
    std::vector<Index> points;
    for (std::size_t rank = 0; rank < by_size.size(); ++rank) {
        const auto piece = pieces.of(by_size[rank]);
        points.clear();
        for (Index t : piece) points.insert(points.end(), triangles[t].begin(), triangles[t].end());
        if (rank > 0 && !chooser.is_worth(piece.size(), points)) continue;
        is_kept[by_size[rank]] = 1;
        chooser.keep(points);
    }
    return is_kept;
}

}  // namespace pointbake
