// Which splats are of a surface follows from sizes and opacities alone; the thresholds were set on
// the few trained models at hand.
#include "io/splats.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/message.h"
#include "core/parallel.h"
#include "io/finish_cloud.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 8192;
constexpr double kHarmonic0 = 0.28209479177387814;  // sqrt(1 / (4 pi))
// What is fainter hardly shows: a third of a trained model, most of it floating in front of or
// inside of the surface.
constexpr float kLeastOpacity = 0.1F;
// Larger than this many medians are backgrounds and mists.
constexpr float kMostMedians = 5.0F;
// The second axis over the first: hairs and edges, whose direction is no surface's.
constexpr float kLeastNeedle = 0.05F;
// The thin axis over the second: from here on it is no normal.
constexpr float kFlat = 0.3F;

enum class Fate : std::uint8_t { kKept, kFaint, kLarge, kNeedle, kBroken };

/// Columns of the rotation matrix of a unit quaternion.
std::array<Vec3d, 3> axes_of(const std::array<double, 4>& q) {
    const auto [w, x, y, z] = q;
    return {Vec3d{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
            Vec3d{2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
            Vec3d{2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}

/// Axes in the order of their sigmas, the thinnest first; ties by axis.
std::array<std::size_t, 3> by_size(const Vec3f& sigmas) {
    std::array<std::size_t, 3> order{0, 1, 2};
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return sigmas[a] < sigmas[b]; });
    return order;
}

float largest(const Vec3f& v) { return std::max({v.x, v.y, v.z}); }

bool is_broken(const Vec3f& sigmas, const std::array<float, 4>& rotation, float opacity) {
    double length = 0.0;
    for (const float q : rotation) length += static_cast<double>(q) * static_cast<double>(q);
    // The squares are wanted later, as floats.
    constexpr float kMostSigma = 1e18F;
    const bool is_whole = is_finite(sigmas) && largest(sigmas) <= kMostSigma &&
                          std::isfinite(length) && length > 0.0 && std::isfinite(opacity);
    return !is_whole || std::min({sigmas.x, sigmas.y, sigmas.z}) < 0.0F;
}

/// What happens to each splat.
std::vector<Fate> fates_of(const SplatShapes& shapes) {
    std::vector<Fate> fates(shapes.sigmas.size(), Fate::kKept);
    std::vector<float> sizes;
    for (std::size_t i = 0; i < fates.size(); ++i) {
        if (is_broken(shapes.sigmas[i], shapes.rotations[i], shapes.opacities[i]))
            fates[i] = Fate::kBroken;
        else if (shapes.opacities[i] < kLeastOpacity)
            fates[i] = Fate::kFaint;
        else
            sizes.push_back(largest(shapes.sigmas[i]));
    }
    if (sizes.empty()) return fates;
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    const float most = kMostMedians * *middle;
    for (std::size_t i = 0; i < fates.size(); ++i) {
        if (fates[i] != Fate::kKept) continue;
        const Vec3f& s = shapes.sigmas[i];
        const float middle_size = s[by_size(s)[1]];
        if (largest(s) > most)
            fates[i] = Fate::kLarge;
        else if (!(middle_size >= kLeastNeedle * largest(s)) || middle_size == 0.0F)
            fates[i] = Fate::kNeedle;
    }
    return fates;
}

void note_fates(const std::vector<Fate>& fates, std::vector<std::string>& notes) {
    const auto note = [&](Fate fate, std::string_view what) {
        const auto count = std::count(fates.begin(), fates.end(), fate);
        if (count > 0)
            notes.push_back(fmt::format("{} dropped: {}",
                                        counted(static_cast<std::uint64_t>(count), "splat"), what));
    };
    note(Fate::kFaint, fmt::format("opacity below {}", kLeastOpacity));
    note(Fate::kLarge, fmt::format("more than {} times the median size", kMostMedians));
    note(Fate::kNeedle,
         fmt::format("needles, thinner than 1 : {}", std::lround(1.0F / kLeastNeedle)));
    note(Fate::kBroken, "size, rotation or opacity is no number, or out of range");
}

void shape_point(PointCloud& cloud, const SplatShapes& shapes, std::size_t i) {
    std::array<double, 4> q{};
    double length = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
        q[k] = static_cast<double>(shapes.rotations[i][k]);
        length += q[k] * q[k];
    }
    for (double& value : q) value /= std::sqrt(length);
    const std::array<Vec3d, 3> axes = axes_of(q);
    const Vec3f& sigmas = shapes.sigmas[i];
    const auto [thin, second, first] = by_size(sigmas);
    const auto sigma = [&](std::size_t k) { return static_cast<double>(sigmas[k]); };
    const bool is_flat = sigmas[thin] < kFlat * sigmas[second];
    cloud.normals[i] = is_flat ? vec_cast<float>(axes[thin]) : Vec3f{};
    cloud.axes[i] = {vec_cast<float>(axes[first] * sigma(first)),
                     vec_cast<float>(axes[second] * sigma(second))};
    const double opacity = std::min(static_cast<double>(shapes.opacities[i]), 1.0);
    cloud.weights[i] = static_cast<float>(opacity);
    cloud.areas[i] =
        static_cast<float>(2.0 * std::numbers::pi * sigma(first) * sigma(second) * opacity);
}

std::uint16_t to_16bit(double unit) {
    if (!(unit > 0.0)) return 0;  // NaN, too
    return static_cast<std::uint16_t>(std::min(unit, 1.0) * 65535.0 + 0.5);
}

}  // namespace

double portable_exp(double x) {
    constexpr double kMost = 700.0;  // the result and all steps stay finite
    constexpr int kTerms = 14;       // |r| <= ln 2 / 2: the next one is below 1e-17
    constexpr double kLn2High = 6.93147180369123816490e-01, kLn2Low = 1.90821492927058770002e-10;
    if (std::isnan(x)) return x;
    x = std::clamp(x, -kMost, kMost);
    const double n = std::floor(x / std::numbers::ln2 + 0.5);
    const double r = (x - n * kLn2High) - n * kLn2Low;
    double sum = 1.0;
    for (int k = kTerms; k > 0; --k) sum = 1.0 + sum * r / k;
    return std::ldexp(sum, static_cast<int>(n));
}

Rgb16 color_of_unit(Vec3d color) {
    return {to_16bit(color.x), to_16bit(color.y), to_16bit(color.z)};
}

Rgb16 color_of_harmonic(Vec3d f_dc) {
    return color_of_unit(f_dc * kHarmonic0 + Vec3d{0.5, 0.5, 0.5});
}

void make_surfels(PointRows& points, const SplatShapes& shapes, const Context& context) {
    points.cloud.frame.up = UpAxis::kMinusY;
    points.cloud.are_splats = true;
    PointCloud& cloud = points.cloud;
    const std::size_t n = cloud.positions.size();
    cloud.normals.assign(n, {});
    cloud.given_normals.assign(n, 0);  // their signs say nothing
    cloud.axes.assign(n, {});
    cloud.weights.assign(n, 0.0F);
    cloud.areas.assign(n, 0.0F);
    const std::vector<Fate> fates = fates_of(shapes);
    parallel_for(context, n, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (fates[i] == Fate::kKept) shape_point(cloud, shapes, i);
    });
    for (std::size_t i = 0; i < n; ++i)
        if (fates[i] != Fate::kKept && is_finite(cloud.positions[i]))
            drop_row(cloud, i, DropReason::kNoSurfel);
    points.notes.emplace_back("Gaussian splats taken as surfels: a proxy of their surface");
    note_fates(fates, points.notes);
}

bool take_shapes(PointCloud& cloud, SplatShapes& shapes, const Context& context) {
    const auto find = [&](std::string_view name) -> const std::vector<float>* {
        for (const Channel& c : cloud.channels)
            if (c.name == name) return &c.data;
        return nullptr;
    };
    constexpr std::array<std::string_view, 8> kNames{"scale_0", "scale_1", "rot_0",   "rot_1",
                                                     "rot_2",   "rot_3",   "opacity", "scale_2"};
    std::array<const std::vector<float>*, 8> data{};
    std::transform(kNames.begin(), kNames.end(), data.begin(), find);
    // 2-D splats have no scale_2.
    if (std::find(data.begin(), data.end() - 1, nullptr) != data.end() - 1) return false;
    const std::size_t n = cloud.positions.size();
    shapes.sigmas.resize(n);
    shapes.rotations.resize(n);
    shapes.opacities.resize(n);
    parallel_for(context, n, kGrain, [&](std::size_t begin, std::size_t end) {
        const auto exp_of = [](float x) {
            return static_cast<float>(portable_exp(static_cast<double>(x)));
        };
        for (std::size_t i = begin; i < end; ++i) {
            shapes.sigmas[i] = {exp_of((*data[0])[i]), exp_of((*data[1])[i]),
                                data[7] == nullptr ? 0.0F : exp_of((*data[7])[i])};
            for (std::size_t k = 0; k < 4; ++k) shapes.rotations[i][k] = (*data[2 + k])[i];
            const auto logit = static_cast<double>((*data[6])[i]);
            shapes.opacities[i] = static_cast<float>(1.0 / (1.0 + portable_exp(-logit)));
        }
    });
    std::erase_if(cloud.channels, [&](const Channel& c) {
        return std::find(kNames.begin(), kNames.end(), c.name) != kNames.end();
    });
    return true;
}

}  // namespace pointbake
