// Connected components of the graph that joins neighbours within a few local spacings. A piece
// floats if it is tiny and nothing else lies within several spacings, its own and the other's.
#include "clean/floaters.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/parallel.h"
#include "core/union_find.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 64;  // points per chunk: some milliseconds of long queries

constexpr std::size_t kEdges = 8;          // neighbours that a point may be joined with
constexpr double kJoined = 4.0;            // farther than this many spacings they are not
constexpr std::size_t kMostPoints = 99;    // of a floating piece
constexpr std::size_t kLeastParts = 1000;  // a floating piece fits so often into the largest one
constexpr double kGap = 8.0;  // spacings; parts of scans that shadows cut off lie nearer
// More than a piece has points, so that the nearest of them that belong to others are seen.
constexpr std::size_t kSeen = 128;

class Pieces {
 public:
    Pieces(const Neighborhoods& near, std::span<const DropReason> fates)
        : near_(near), fates_(fates), piece_(fates.size()), size_(fates.size(), 0) {
        UnionFind sets(fates.size());
        for (std::size_t i = 0; i < fates.size(); ++i)
            if (is_kept(i)) join(sets, i);
        for (std::size_t i = 0; i < fates.size(); ++i) {
            piece_[i] = sets.find(static_cast<Index>(i));
            if (is_kept(i)) ++size_[piece_[i]];
        }
        largest_ = *std::ranges::max_element(size_);
    }

    bool is_tiny(std::size_t point) const {
        const std::size_t size = size_[piece_[point]];
        return is_kept(point) && size <= kMostPoints && size * kLeastParts < largest_;
    }
    Index of(std::size_t point) const { return piece_[point]; }

    /// Distance to the nearest point of another piece, in spacings.
    double gap(std::size_t point) const {
        std::array<Neighbor, kSeen> buffer;
        const auto found = near_.tree.nearest(near_.positions[point], buffer);
        double gap = std::numeric_limits<double>::infinity();
        for (const Neighbor& other : found)
            if (is_kept(other.index) && piece_[other.index] != piece_[point])
                gap = std::min(gap, in_spacings(other.squared_distance, point, other.index));
        return gap;
    }

 private:
    bool is_kept(std::size_t point) const { return fates_[point] == DropReason::kKept; }

    double in_spacings(double squared_distance, std::size_t a, std::size_t b) const {
        return std::sqrt(squared_distance) / std::max(near_.spacing[a], near_.spacing[b]);
    }

    void join(UnionFind& sets, std::size_t point) const {
        for (const Index other : near_.of(point).first(kEdges)) {
            const Vec3d edge = near_.positions[other] - near_.positions[point];
            if (is_kept(other) && in_spacings(squared_length(edge), point, other) <= kJoined)
                sets.unite(static_cast<Index>(point), other);
        }
    }

    const Neighborhoods& near_;
    std::span<const DropReason> fates_;
    std::vector<Index> piece_;  // lowest point of each point's piece
    std::vector<Index> size_;   // of the piece, at its lowest point
    Index largest_ = 0;
};

}  // namespace

FloaterCounts mark_floaters(const Neighborhoods& near, std::span<DropReason> fates,
                            const Context& context) {
    const Pieces pieces(near, fates);
    std::vector<Index> tiny;
    for (std::size_t i = 0; i < fates.size(); ++i)
        if (pieces.is_tiny(i)) tiny.push_back(static_cast<Index>(i));
    std::vector<double> gaps(tiny.size());
    parallel_for(context, tiny.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) gaps[k] = pieces.gap(tiny[k]);
    });
    std::vector<std::uint8_t> is_near(fates.size(), 0);  // by piece
    for (std::size_t k = 0; k < tiny.size(); ++k)
        if (gaps[k] <= kGap) is_near[pieces.of(tiny[k])] = 1;

    FloaterCounts counts;
    for (const Index i : tiny) {
        if (is_near[pieces.of(i)]) continue;
        fates[i] = DropReason::kFloating;
        ++counts.num_points;
        if (pieces.of(i) == i) ++counts.num_pieces;
    }
    return counts;
}

}  // namespace pointbake
