// Poisson-disk thinning by dart throwing [Cook86] over the points, in the order of a hash of their
// coordinates: a point stays if none that stayed is nearer than the spacing.
#include "clean/subsample.h"

#include <bit>
#include <cmath>

#include "core/hash.h"
#include "core/parallel_sort.h"

namespace pointbake {
namespace {

// Keeps rounding from putting points that are a spacing apart two cells apart.
constexpr double kCellSlack = 1.0 + 1e-9;
constexpr std::size_t kPointsPerPoll = 65536;

/// By coordinate; -0 hashes as 0.
std::uint64_t axis_hash(std::size_t axis, double x) {
    return hash64(axis, std::bit_cast<std::uint64_t>(x + 0.0));
}

std::uint64_t cell_hash(Vec3d v) {
    return axis_hash(0, v.x) + axis_hash(1, v.y) + axis_hash(2, v.z);
}

/// The points that stay, in lists by cells of a grid anchored at the origin. Cells share lists by
/// chance: distances decide.
class KeptPoints {
 public:
    KeptPoints(std::span<const Vec3d> positions, double spacing)
        : positions_(positions),
          spacing_(spacing),
          heads_(std::bit_ceil(positions.size()), kInvalidIndex),
          next_(positions.size(), kInvalidIndex) {}

    void add(Index i) {
        Index& head = heads_[cell_hash(cell_of(positions_[i])) & mask()];
        next_[i] = head;
        head = i;
    }

    bool has_near(Index i) const {
        const Vec3d cell = cell_of(positions_[i]);
        std::uint64_t hashes[3][3];  // by axis, of the cell and those beside it
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t n = 0; n < 3; ++n)
                hashes[k][n] = axis_hash(k, cell[k] + static_cast<double>(n) - 1.0);
        for (std::size_t n = 0; n < 27; ++n) {
            const std::uint64_t hash = hashes[0][n % 3] + hashes[1][n / 3 % 3] + hashes[2][n / 9];
            for (Index k = heads_[hash & mask()]; k != kInvalidIndex; k = next_[k])
                if (length(positions_[k] - positions_[i]) < spacing_) return true;
        }
        return false;
    }

 private:
    Vec3d cell_of(Vec3d p) const {
        const double side = spacing_ * kCellSlack;
        return {std::floor(p.x / side), std::floor(p.y / side), std::floor(p.z / side)};
    }
    std::size_t mask() const { return heads_.size() - 1; }

    std::span<const Vec3d> positions_;
    double spacing_;
    std::vector<Index> heads_, next_;
};

struct Turn {
    std::uint64_t hash = 0;
    Index point = 0;
    friend auto operator<=>(const Turn&, const Turn&) = default;
};

}  // namespace

std::uint64_t mark_subsampled(std::span<const Vec3d> positions, double spacing,
                              std::span<DropReason> fates, const Context& context) {
    std::vector<Turn> turns;
    turns.reserve(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i)
        turns.push_back({hash_of(positions[i]), static_cast<Index>(i)});
    parallel_sort(context, turns);

    KeptPoints kept(positions, spacing);
    std::uint64_t num_dropped = 0;
    for (std::size_t t = 0; t < turns.size(); ++t) {
        if (t % kPointsPerPoll == 0) check_cancelled(context);
        const Index i = turns[t].point;
        if (kept.has_near(i)) {
            fates[i] = DropReason::kSubsampled;
            ++num_dropped;
        } else {
            kept.add(i);
        }
    }
    return num_dropped;
}

}  // namespace pointbake
