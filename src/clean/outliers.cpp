// Statistical outlier removal [Rusu08]: the mean distance to the neighbours against its
// distribution over the cloud, robustly on its logarithm. Alone that drops sparse parts of clouds
// whose density jumps or falls with range. So a point is also compared with its neighbours, as
// [Breunig00] does, and what is merely sparse must be off its neighbours' plane, or scattered in
// space instead of along a surface, creases included.
#include "clean/outliers.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/median.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 4096;  // points per chunk: about a millisecond

// A point's mean distance over its neighbours'. Random points on a surface reach 1.9, scans 2;
// four spacings off a plane is 2.7. A point on the surface beside a part of it that is 16 times
// denser reaches 3.6: below that, a point must be off the plane of its neighbours.
constexpr double kIsolated = 2.5;
constexpr double kSparseIsolated = 2.0;  // where the point is sparse against the whole cloud, too
constexpr double kFarIsolated = 3.5;
// Of its 16 neighbours no more count it among theirs. Beside a jump in density a sparse point on
// the surface has some on its other side.
constexpr int kMutual = 2;
// Sparse: mean distance beyond the median by this factor, or by four standard deviations of the
// logarithm: six median deviations. As a power of a ratio, since log() differs between machines.
constexpr double kSparseFactor = 2.0;
constexpr int kMedianDeviations = 6;
constexpr double kVerySparse = 3.0;  // so many times that: no part of a surface is, beside another
// Roundness of neighbourhoods: 0 for planes and lines, 1 for balls. Noise of 0.3 spacings on a
// surface gives 0.1, a crease of 90 degrees 0.4; 16 random points in space give 0.6.
constexpr double kOffPlane = 0.05;
constexpr double kScattered = 0.45;
constexpr double kMaybeScattered = 0.25;
// Sparse points most of whose sparse neighbours are outliers are outliers, and scattered ones many
// of whose are.
constexpr int kFewestOutliers = 3;
constexpr double kMostOutliers = 0.6;
constexpr double kManyOutliers = 0.35;
constexpr int kMostRounds = 32;

/// Mean distances above this are sparse.
double sparse_reach(std::vector<double> reach) {
    const double median = median_in_place(std::span<double>(reach));
    if (!(median > 0.0)) return HUGE_VAL;  // most points lie upon others
    for (double& r : reach) r = std::max(r / median, median / r);
    const double deviation = median_in_place(std::span<double>(reach));
    double factor = 1.0;
    for (int i = 0; i < kMedianDeviations; ++i) factor *= deviation;
    return median * std::max(kSparseFactor, factor);
}

/// 27 det(C) / trace(C)^3 of the covariance of a point and its neighbours: 1 if all its
/// eigenvalues are equal, 0 if one is 0.
double roundness(const Neighborhoods& near, std::size_t point) {
    std::array<Vec3d, kNeighbors + 1> q{};  // the point itself is the origin
    Vec3d mean;
    for (std::size_t k = 0; k < kNeighbors; ++k) {
        q[k] = (near.positions[near.of(point)[k]] - near.positions[point]) / near.reach[point];
        mean += q[k];
    }
    mean = mean / static_cast<double>(q.size());
    Vec3d rows[3];
    for (const Vec3d& p : q) {
        const Vec3d d = p - mean;
        for (std::size_t r = 0; r < 3; ++r) rows[r] += d * d[r];
    }
    const double trace = rows[0].x + rows[1].y + rows[2].z;
    return 27.0 * dot(rows[0], cross(rows[1], rows[2])) / (trace * trace * trace);
}

class OutlierSearch {
 public:
    OutlierSearch(const Neighborhoods& near, const Context& context)
        : near_(near), context_(context), sparse_reach_(sparse_reach(near.reach)) {
        for (std::size_t i = 0; i < near.positions.size(); ++i)
            if (is_sparse(i)) sparse_.push_back(static_cast<Index>(i));
    }

    std::vector<std::uint8_t> run() const {
        std::vector<std::uint8_t> marks(near_.positions.size(), 0);
        parallel_for(context_, marks.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) marks[i] = is_isolated(i);
        });
        for_sparse([&](Index i) { marks[i] = marks[i] || is_scattered(i); });
        for (int round = 0; round < kMostRounds; ++round) {
            std::vector<std::uint8_t> grown = marks;
            for_sparse([&](Index i) { grown[i] = is_among_outliers(i, marks); });
            if (grown == marks) break;
            marks = std::move(grown);
        }
        return marks;
    }

 private:
    template <class Body>
    void for_sparse(Body&& body) const {
        parallel_for(context_, sparse_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) body(sparse_[k]);
        });
    }

    bool is_sparse(std::size_t i) const { return near_.reach[i] > sparse_reach_; }

    double contrast(std::size_t i) const {
        std::array<double, kNeighbors> reach;
        std::ranges::transform(near_.of(i), reach.begin(), [&](Index j) { return near_.reach[j]; });
        return near_.reach[i] / median_in_place(std::span<double>(reach));
    }

    int num_mutual(std::size_t i) const {
        return static_cast<int>(std::ranges::count_if(near_.of(i), [&](Index j) {
            return std::ranges::find(near_.of(j), i) != near_.of(j).end();
        }));
    }

    bool is_isolated(std::size_t i) const {
        const double ratio = contrast(i);
        if (!(ratio > kSparseIsolated)) return false;
        const bool is_off = roundness(near_, i) > kOffPlane;
        if (num_mutual(i) > kMutual) return is_off && is_sparse(i) && ratio > kFarIsolated;
        return (ratio > kIsolated || is_sparse(i)) && (is_off || ratio > kFarIsolated);
    }

    /// Mean roundness of the neighbourhoods, its own and its neighbours'.
    double scatter(std::size_t i) const {
        double sum = 0.0;
        for (const Index j : near_.of(i)) sum += roundness(near_, j);
        return 0.5 * (sum / kNeighbors + roundness(near_, i));
    }

    bool is_scattered(std::size_t i) const {
        const bool is_very_sparse = near_.reach[i] > kVerySparse * sparse_reach_;
        return scatter(i) > (is_very_sparse ? kMaybeScattered : kScattered);
    }

    bool is_among_outliers(std::size_t i, const std::vector<std::uint8_t>& marks) const {
        if (marks[i]) return true;
        int num_outliers = 0, num_sparse = 0;
        for (const Index j : near_.of(i)) {
            num_outliers += marks[j];
            num_sparse += is_sparse(j) ? 1 : 0;
        }
        if (num_outliers < kFewestOutliers || num_outliers < kManyOutliers * num_sparse)
            return false;
        return num_outliers >= kMostOutliers * num_sparse || scatter(i) > kMaybeScattered;
    }

    const Neighborhoods& near_;
    const Context& context_;
    double sparse_reach_;
    std::vector<Index> sparse_;
};

}  // namespace

std::uint64_t mark_outliers(const Neighborhoods& near, std::span<DropReason> fates,
                            const Context& context) {
    const std::vector<std::uint8_t> marks = OutlierSearch(near, context).run();
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < marks.size(); ++i) {
        if (!marks[i]) continue;
        fates[i] = DropReason::kOutlier;
        ++count;
    }
    return count;
}

}  // namespace pointbake
