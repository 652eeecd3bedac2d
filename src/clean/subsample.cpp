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

std::uint64_t hash_of(Vec3d v) {
    std::uint64_t hash = 0;
    for (std::size_t k = 0; k < 3; ++k)  // -0 hashes as 0
        hash = hash64(hash, std::bit_cast<std::uint64_t>(v[k] + 0.0));
    return hash;
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
        Index& head = heads_[list(cell_of(positions_[i]))];
        next_[i] = head;
        head = i;
    }

    bool has_near(Index i) const {
        const Vec3d cell = cell_of(positions_[i]);
        for (int n = 0; n < 27; ++n) {
            const Vec3d offset{n % 3 - 1.0, n / 3 % 3 - 1.0, n / 9 - 1.0};
            for (Index k = heads_[list(cell + offset)]; k != kInvalidIndex; k = next_[k])
                if (length(positions_[k] - positions_[i]) < spacing_) return true;
        }
        return false;
    }

 private:
    Vec3d cell_of(Vec3d p) const {
        const double side = spacing_ * kCellSlack;
        return {std::floor(p.x / side), std::floor(p.y / side), std::floor(p.z / side)};
    }
    std::size_t list(Vec3d cell) const { return hash_of(cell) & (heads_.size() - 1); }

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
