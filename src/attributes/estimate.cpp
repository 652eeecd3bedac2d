// Normals: smallest eigenvector of the neighbours' covariance [Hoppe92], with Gaussian weights and
// the eigenvalues as a check of rank [Pauly03]. Areas: the disc through the k-th neighbour holds k
// points [Loftsgaarden65].
#include <algorithm>
#include <array>

#include "attributes/spacing.h"
#include "core/kdtree.h"
#include "core/message.h"
#include "core/parallel.h"
#include "core/symmetric_eigen.h"
#include "pointbake/attributes.h"

namespace pointbake {
namespace {

constexpr Index kFewestNeighbors = 3;   // a plane needs three points
constexpr Index kMostNeighbors = 1024;  // beyond, nothing about the neighbourhood is local
// Where the neighbours lie on a line their number is doubled, up to this: scan lines 4 times
// farther apart than the samples along them need 16 to 32.
constexpr std::size_t kMostGrownNeighbors = 64;
// Second eigenvalue over the largest below which neighbours lie on a line [Pauly03].
constexpr double kLineRatio = 0.05;

// Neighbour counts whose discs are averaged. A single one is biased on lattices (k = 8: -21 % on a
// square one); these together are within 3.5 % on square and hexagonal lattices and unbiased on
// random points.
constexpr std::array<std::size_t, 5> kAreaCounts{6, 8, 11, 12, 15};
constexpr std::size_t kAreaNeighbors = kAreaCounts.back() + 1;  // the point itself is the first
constexpr double kPi = 3.141592653589793;

constexpr std::size_t kGrain = 512;                        // points per chunk: about a millisecond
constexpr std::size_t kBlock = std::size_t{512} * kGrain;  // points between two progress reports

void validate(const AttributesOptions& options) {
    if (options.neighbors < kFewestNeighbors || options.neighbors > kMostNeighbors)
        fail(ErrorCode::kInvalidOption, "neighbors is {}; {} to {} are accepted", options.neighbors,
             kFewestNeighbors, kMostNeighbors);
}

/// exp(-2 t) for t in [0, 1], within 2e-7: a Gaussian whose standard deviation is half the distance
/// at t = 1. exp() itself differs from machine to machine.
double gaussian_weight(double t) {
    const double x = 0.25 * t;
    const double e = 1.0 - x * (1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0))));
    const double e2 = e * e, e4 = e2 * e2;
    return e4 * e4;
}

/// The axis that lies closest to the normal points forward: a sign for those who have none yet.
Vec3d with_canonical_sign(Vec3d n) {
    const Vec3d a{std::fabs(n.x), std::fabs(n.y), std::fabs(n.z)};
    const double leading = a.x >= a.y && a.x >= a.z ? n.x : (a.y >= a.z ? n.y : n.z);
    return leading < 0.0 ? -n : n;
}

/// Normal of the plane through the neighbours; zero if they lie on a line or in one place.
Vec3f fit_normal(std::span<const Vec3d> positions, Vec3d p, std::span<const Neighbor> neighbors) {
    if (neighbors.size() < kFewestNeighbors) return {};
    const double farthest = neighbors.back().squared_distance;
    if (!(farthest > 0.0)) return {};
    const double scale = 1.0 / std::sqrt(farthest);

    // Relative to p and in units of the farthest distance: no cancellation, no underflow.
    double sum = 0.0;
    Vec3d mean;
    SymmetricMatrix c;
    for (const Neighbor& neighbor : neighbors) {
        const Vec3d q = (positions[neighbor.index] - p) * scale;
        const double w = gaussian_weight(neighbor.squared_distance / farthest);
        sum += w;
        mean += q * w;
        c.add(q, w);
    }
    c.add(mean, -1.0 / sum);

    const EigenSystem e = eigen_system(c);
    if (!(e.values[1] >= kLineRatio * e.values[2])) return {};
    return vec_cast<float>(normalized(with_canonical_sign(e.vectors[0])));
}

double area_of_discs(std::span<const Neighbor> neighbors) {
    double sum = 0.0;
    int count = 0;
    for (const std::size_t k : kAreaCounts) {
        if (k >= neighbors.size()) break;
        sum += neighbors[k].squared_distance / static_cast<double>(k);
        ++count;
    }
    if (count > 0) return kPi * sum / count;
    const std::size_t k = neighbors.size() - 1;
    return k == 0 ? 0.0 : kPi * neighbors[k].squared_distance / static_cast<double>(k);
}

bool is_known(Vec3f normal) { return is_finite(normal) && squared_length(normal) > 0.0F; }

/// One pass over the points with one query each; every point writes its own entries only.
class Estimator {
 public:
    Estimator(PointCloud& cloud, const AttributesOptions& options)
        : cloud_(cloud),
          tree_(cloud.positions),
          neighbors_(options.neighbors),
          has_areas_(cloud.areas.size() == cloud.size()),
          has_radii_(cloud.radii.size() == cloud.size()) {
        cloud_.normals.resize(cloud.size());
        cloud_.areas.resize(cloud.size());
        cloud_.radii.resize(cloud.size());
    }

    /// Number of normals estimated in the range.
    std::uint64_t estimate(std::size_t begin, std::size_t end) const {
        const std::size_t num_first = std::max(neighbors_, kAreaNeighbors);
        std::vector<Neighbor> buffer(std::max(num_first, kMostGrownNeighbors));
        std::uint64_t num_estimated = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const bool needs_normal = !is_known(cloud_.normals[i]);
            if (!needs_normal && has_areas_ && has_radii_) continue;
            const Vec3d p = cloud_.positions[i];
            const auto found = tree_.nearest(p, std::span(buffer).first(num_first));
            if (!has_areas_) cloud_.areas[i] = static_cast<float>(area_of_discs(found));
            if (!has_radii_ || !(cloud_.radii[i] > 0.0F && std::isfinite(cloud_.radii[i])))
                cloud_.radii[i] = equivalent_spacing(cloud_.areas[i]);
            if (!needs_normal) continue;
            cloud_.normals[i] = estimate_normal(p, found, buffer);
            ++num_estimated;
        }
        return num_estimated;
    }

 private:
    Vec3f estimate_normal(Vec3d p, std::span<const Neighbor> found,
                          std::span<Neighbor> buffer) const {
        const std::span<const Vec3d> positions = cloud_.positions;
        std::size_t k = neighbors_;
        Vec3f normal = fit_normal(positions, p, found.first(std::min(k, found.size())));
        while (!is_known(normal) && k < kMostGrownNeighbors && k < positions.size()) {
            k = std::min(2 * k, kMostGrownNeighbors);
            normal = fit_normal(positions, p, tree_.nearest(p, buffer.first(k)));
        }
        return normal;
    }

    PointCloud& cloud_;
    KdTree tree_;
    std::size_t neighbors_;
    bool has_areas_, has_radii_;
};

/// Before the unknown ones are estimated. A second run adds none.
void note_given_normals(PointCloud& cloud) {
    if (cloud.normals.empty()) cloud.given_normals.clear();
    if (cloud.normals.size() != cloud.size() || cloud.given_normals.size() == cloud.size()) return;
    cloud.given_normals.resize(cloud.size());
    std::transform(cloud.normals.begin(), cloud.normals.end(), cloud.given_normals.begin(),
                   [](Vec3f normal) { return is_known(normal) ? 1 : 0; });
}

}  // namespace

AttributesResult estimate_attributes(PointCloud cloud, const AttributesOptions& options,
                                     const Context& context) {
    validate(options);
    check_cancelled(context);
    AttributesResult result{std::move(cloud), {}};
    const std::size_t n = result.cloud.size();
    report_progress(context, "attributes", 0.0);

    note_given_normals(result.cloud);
    const Estimator estimator(result.cloud, options);
    const auto add = [](std::uint64_t a, std::uint64_t b) { return a + b; };
    for (std::size_t first = 0; first < n; first += kBlock) {
        const std::size_t count = std::min(kBlock, n - first);
        result.report.num_estimated_normals += parallel_reduce(
            context, count, kGrain, std::uint64_t{0},
            [&](std::size_t begin, std::size_t end) {
                return estimator.estimate(first + begin, first + end);
            },
            add);
        report_progress(context, "attributes",
                        static_cast<double>(first + count) / static_cast<double>(n));
    }

    result.report.num_invalid_normals = static_cast<std::uint64_t>(
        std::count(result.cloud.normals.begin(), result.cloud.normals.end(), Vec3f{}));
    result.report.median_spacing = median_spacing(result.cloud.areas);
    return result;
}

}  // namespace pointbake
