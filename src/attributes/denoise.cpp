// Points onto local quadrics, each fitted to the neighbourhood that suits it.
#include "pointbake/denoise.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/hash.h"
#include "core/local_quadric.h"
#include "core/median.h"
#include "core/message.h"
#include "core/noise.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr std::size_t kFewestPoints = 64;
constexpr std::size_t kMostMeasured = 20000;  // points that the cloud's noise is measured at
// Neighbours of the quadrics that noise is measured against. Few: more reach other walls and take
// relief for noise (a clean tea set reads 0.01 with 12, 0.9 with 32). But a layer as thick as the
// ball of the few is cut by it, so from kMuchNoise on there are more of them. The median of a
// deviation with 6 or 26 degrees of freedom is a little less than the deviation.
constexpr std::size_t kFewNeighbors = 12, kSomeNeighbors = 16, kManyNeighbors = 32;
constexpr double kMedianOfFew = 0.944, kMedianOfMany = 0.987;
constexpr double kMuchNoise = 0.2;
// What many read over what few do. Noise of 1.5 spacings on a sphere reaches 1.57; two noisy
// walls 2.7 or 3 spacings apart reach 2.6 and more.
constexpr double kOtherWall = 1.8;
// Noise at a point over that of the cloud, at most: more is structure.
constexpr double kMostUneven = 4.0;
constexpr std::size_t kSmoothNeighbors = 48;  // whose median is the noise at a point

// Neighbourhoods that are tried: the first, in the noise in spacings (the ball must be much larger
// than the layer is thick), how they grow, and the last. Those of the frame are about five noises
// wide.
constexpr double kFirstOfNone = 16.0, kFirstPerNoise = 30.0, kGrowth = 1.35;
constexpr std::size_t kNearNeighbors = 64, kMostNeighbors = 200;
constexpr double kFramePerNoise2 = 78.0, kFewestInFrame = 24.0, kMostInFrame = 150.0;
// Half width of a confidence interval in standard deviations. Small: neighbourhoods that are too
// large round off creases, and what they would gain comes back by blending. Mean distance to spot's
// true surface, 1e-4 of its diagonal, at noises of 0.1, 0.3 and 1 spacings: 1.5 1.29, 2.07, -;
// 0.7 1.03, 2.09, 5.20; 0.4 1.12, 2.55, 6.23; blended, 0.5: 1.02, 1.89, 4.3.
constexpr double kConfidence = 0.5;
// Quadrics of the neighbours are blended where a point is within this share of their radius.
constexpr std::size_t kBlended = 48;
constexpr double kBlendRadius = 0.6;

// In standard deviations: what lies farther off is something else than noise.
constexpr double kFarthest = 5.0;

// Share of what was measured. More than that does not go away by denoising: it is no noise.
constexpr double kMostLeft = 0.5;

constexpr std::size_t kGrain = 256;
constexpr std::string_view kStage = "attributes";

/// What the neighbours of a point say about noise; a negative deviation is unknown.
struct LocalNoise {
    double deviation = -1.0, spacing = 0.0;
};

LocalNoise noise_around(const KdTree& tree, std::span<const Vec3d> positions, Vec3d p,
                        std::size_t num_neighbors) {
    std::array<Neighbor, kManyNeighbors> buffer;
    const auto found = tree.nearest(p, std::span(buffer).first(num_neighbors));
    const double radius2 = found.back().squared_distance;
    LocalNoise noise;
    noise.spacing = std::sqrt(kPi * radius2 / static_cast<double>(found.size() - 1));
    if (!(noise.spacing > 0.0)) return noise;
    const auto frame = tangent_frame(positions, p, found);
    if (!frame) return noise;
    QuadricFit fit(*frame, std::sqrt(radius2));
    for (const Neighbor& n : found) fit.add(positions[n.index]);
    if (const auto quadric = fit.solve()) noise.deviation = std::sqrt(quadric->variance);
    return noise;
}

// Those whose hash is small: the same ones in any order of the points.
std::vector<Index> some_points(std::span<const Vec3d> positions) {
    const std::size_t n = positions.size(), stride = (n + kMostMeasured - 1) / kMostMeasured;
    std::vector<Index> some;
    for (Index i = 0; i < n; ++i)
        if (hash_of(positions[i]) % stride == 0) some.push_back(i);
    return some;
}

double median_noise(const KdTree& tree, std::span<const Vec3d> positions, std::size_t num_neighbors,
                    const Context& context) {
    const std::vector<Index> some = some_points(positions);
    std::vector<float> noise(some.size());
    parallel_for(context, some.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const LocalNoise local =
                noise_around(tree, positions, positions[some[k]], num_neighbors);
            noise[k] =
                local.spacing > 0.0 ? static_cast<float>(local.deviation / local.spacing) : -1.0F;
        }
    });
    std::erase_if(noise, [](float v) { return v < 0.0F; });
    return static_cast<double>(median_in_place(std::span(noise)));
}

/// In spacings, and the neighbours to measure it with at a point.
struct CloudNoise {
    double deviation = 0.0;
    std::size_t num_neighbors = kSomeNeighbors;
};

CloudNoise measure(const KdTree& tree, std::span<const Vec3d> positions, const Context& context) {
    const double few = median_noise(tree, positions, kFewNeighbors, context) / kMedianOfFew;
    if (few < kMuchNoise) return {few, kSomeNeighbors};
    const double many = median_noise(tree, positions, kManyNeighbors, context) / kMedianOfMany;
    if (many > kOtherWall * few) return {few, kSomeNeighbors};
    return {many, kManyNeighbors};
}

/// The surface around a point, as far as its radius.
struct SurfacePatch {
    TangentFrame frame;
    std::array<double, 6> c{};
    double squared_radius = 0.0;  ///< 0 = none

    /// Of a place near the patch, one step along its normal.
    Vec3d foot(Vec3d p) const {
        const Vec3d d = p - frame.origin;
        const double x = dot(d, frame.u), y = dot(d, frame.v), z = dot(d, frame.normal);
        const double h = c[0] + (c[1] + c[3] * x + c[4] * y) * x + (c[2] + c[5] * y) * y - z;
        const double dx = c[1] + 2.0 * c[3] * x + c[4] * y, dy = c[2] + c[4] * x + 2.0 * c[5] * y;
        const Vec3d n = frame.normal - frame.u * dx - frame.v * dy;
        return p + n * (h / squared_length(n));
    }
};

class Denoiser {
 public:
    Denoiser(const KdTree& tree, std::span<const Vec3d> positions, CloudNoise noise,
             const Context& context)
        : tree_(tree),
          positions_(positions),
          context_(context),
          most_noise_(kMostUneven * noise.deviation),
          num_neighbors_(noise.num_neighbors) {}

    std::vector<Vec3d> run() {
        find_noise();
        report_progress(context_, kStage, 0.2);
        find_patches();
        report_progress(context_, kStage, 0.6);
        return blend();
    }

 private:
    template <class Body>
    void for_all(Body&& body) const {
        parallel_for(context_, positions_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            std::vector<Neighbor> buffer(kMostNeighbors);
            for (std::size_t i = begin; i < end; ++i) body(i, std::span(buffer));
        });
    }

    void find_noise() {
        std::vector<float> raw(positions_.size());
        spacing_.resize(positions_.size());
        for_all([&](std::size_t i, std::span<Neighbor>) {
            const LocalNoise local = noise_around(tree_, positions_, positions_[i], num_neighbors_);
            raw[i] = static_cast<float>(local.deviation);
            spacing_[i] = static_cast<float>(local.spacing);
        });
        noise_.resize(positions_.size());
        for_all([&](std::size_t i, std::span<Neighbor> buffer) {
            std::vector<float> values;
            for (const Neighbor& n : tree_.nearest(positions_[i], buffer.first(kSmoothNeighbors)))
                if (raw[n.index] >= 0.0F) values.push_back(raw[n.index]);
            noise_[i] =
                static_cast<float>(std::min(static_cast<double>(median_in_place(std::span(values))),
                                            most_noise_ * static_cast<double>(spacing_[i])));
        });
    }

    void find_patches() {
        patches_.resize(positions_.size());
        for_all([&](std::size_t i, std::span<Neighbor> buffer) {
            // Most stop growing early.
            if (!grow(i, tree_.nearest(positions_[i], buffer.first(kNearNeighbors))))
                grow(i, tree_.nearest(positions_[i], buffer));
        });
    }

    // False if the neighbours ended before the agreement did.
    bool grow(std::size_t i, std::span<const Neighbor> found) {
        const double sigma = static_cast<double>(noise_[i]);
        const double spacing = static_cast<double>(spacing_[i]);
        const double noise = spacing > 0.0 ? sigma / spacing : 0.0;
        const double in_frame =
            std::clamp(kFramePerNoise2 * noise * noise, kFewestInFrame, kMostInFrame);
        if (in_frame > static_cast<double>(found.size()) && found.size() == kNearNeighbors)
            return false;
        const auto frame =
            tangent_frame(positions_, positions_[i],
                          found.first(std::min(found.size(), static_cast<std::size_t>(in_frame))));
        if (!frame) return true;
        QuadricFit fit(*frame, spacing);
        double low = -HUGE_VAL, high = HUGE_VAL;
        std::size_t used = 0;
        for (double k = kFirstOfNone + kFirstPerNoise * noise; used < found.size(); k *= kGrowth) {
            const auto count = std::min(found.size(), static_cast<std::size_t>(k));
            for (; used < count; ++used) fit.add(positions_[found[used].index]);
            const auto q = fit.solve();
            if (!q) continue;
            const double reach = kConfidence * sigma * std::sqrt(q->leverage);
            low = std::max(low, q->c[0] - reach);
            high = std::min(high, q->c[0] + reach);
            if (low > high) return true;
            patches_[i] = {*frame, q->c, found[used - 1].squared_distance};
        }
        return found.size() != kNearNeighbors;
    }

    std::vector<Vec3d> blend() const {
        std::vector<Vec3d> out(positions_.begin(), positions_.end());
        for_all([&](std::size_t i, std::span<Neighbor> buffer) {
            const Vec3d p = positions_[i];
            Vec3d sum;
            double weights = 0.0;
            for (const Neighbor& n : tree_.nearest(p, buffer.first(kBlended))) {
                const SurfacePatch& patch = patches_[n.index];
                const double reach2 = kBlendRadius * kBlendRadius * patch.squared_radius;
                if (!(n.squared_distance < reach2)) continue;
                const double t = 1.0 - n.squared_distance / reach2;
                sum += (patch.foot(p) - p) * (t * t);
                weights += t * t;
            }
            const double most = kFarthest * static_cast<double>(noise_[i]) * weights;
            if (weights > 0.0 && squared_length(sum) <= most * most)
                out[i] = p + sum * (1.0 / weights);
        });
        return out;
    }

    const KdTree& tree_;
    std::span<const Vec3d> positions_;
    const Context& context_;
    double most_noise_;  // in spacings
    std::size_t num_neighbors_;
    std::vector<float> noise_, spacing_;  // per point, cloud units
    std::vector<SurfacePatch> patches_;
};

void tell_shift(const PointCloud& cloud, DenoiseReport& report) {
    double sum = 0.0, most = 0.0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const double d2 = squared_length(cloud.positions[i] - cloud.measured[i]);
        sum += d2;
        most = std::max(most, d2);
    }
    report.shift_rms = std::sqrt(sum / static_cast<double>(cloud.size()));
    report.shift_max = std::sqrt(most);
}

}  // namespace

double measure_noise(const PointCloud& cloud, const Context& context) {
    if (cloud.size() < kFewestPoints) return 0.0;
    return measure(KdTree(cloud.positions), cloud.positions, context).deviation;
}

DenoiseResult denoise(PointCloud cloud, const DenoiseOptions& options, const Context& context) {
    DenoiseResult result{std::move(cloud), {}};
    DenoiseReport& report = result.report;
    if (result.cloud.size() < kFewestPoints) return result;
    std::vector<Vec3d> moved;
    {
        const KdTree tree(result.cloud.positions);
        const CloudNoise noise = measure(tree, result.cloud.positions, context);
        report.noise = report.noise_left = noise.deviation;
        report.is_measured = true;
        if (options.denoise == Denoise::kOff) return result;  // only told
        result.cloud.noise = report.noise;
        if (options.denoise == Denoise::kAuto && report.noise < kLeastNoise) {
            log(context, LogLevel::kInfo, "denoise: noise of {:.3f} spacings: left as it is",
                report.noise);
            return result;
        }
        moved = Denoiser(tree, result.cloud.positions, noise, context).run();
    }
    const double left = measure(KdTree(moved), moved, context).deviation;
    if (options.denoise == Denoise::kAuto && left > kMostLeft * report.noise) {
        report.is_relief = true;
        result.cloud.noise = 0.0;
        log(context, LogLevel::kInfo,
            "denoise: noise of {:.2f} spacings, {:.2f} would be left: no noise, left as it is",
            report.noise, left);
        return result;
    }
    report.is_done = true;
    result.cloud.measured = std::move(result.cloud.positions);
    result.cloud.positions = std::move(moved);
    result.cloud.noise = report.noise_left = left;
    tell_shift(result.cloud, report);
    log(context, LogLevel::kInfo,
        "denoise: noise of {:.2f} spacings, {:.2f} left; points moved by {:.4g} (RMS), {:.4g} at "
        "most",
        report.noise, report.noise_left, report.shift_rms, report.shift_max);
    return result;
}

}  // namespace pointbake
