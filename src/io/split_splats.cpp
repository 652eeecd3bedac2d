#include "io/split_splats.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/parallel.h"
#include "io/splats.h"

namespace pointbake {
namespace {

// In standard deviations: an opaque splat hides half of what is behind it up to here.
constexpr double kReach = 1.2;
constexpr double kLeastStep = 2.0;  // in median radii
constexpr std::uint64_t kMostAdded = 2;
constexpr double kStepGrowth = 1.1;
// Deviation of a part over the step: Gaussians that far apart sum up to a flat function.
constexpr double kPartSigma = 0.5;

/// The steps that a splat's ellipse has room for on either side, along both axes.
struct Steps {
    int first = 0, second = 0;

    Steps(const TangentAxes& axes, double step)
        : first(count(axes.u, step)), second(count(axes.v, step)) {}

    /// Calls visit(i, j) for the places besides the centre.
    template <class Visit>
    void for_each(Visit&& visit) const {
        const auto share = [](int i, int most) {
            return most == 0 ? 0.0 : static_cast<double>(i) / most;
        };
        for (int i = -first; i <= first; ++i)
            for (int j = -second; j <= second; ++j) {
                const double a = share(i, first), b = share(j, second);
                if ((i != 0 || j != 0) && a * a + b * b <= 1.0) visit(i, j);
            }
    }

 private:
    static int count(const Vec3f& axis, double step) {
        // Small: those kept are at most 5 medians long, and no needles.
        return static_cast<int>(kReach * length(vec_cast<double>(axis)) / step);
    }
};

double median_radius(const PointCloud& cloud) {
    std::vector<double> radii;
    for (std::size_t i = 0; i < cloud.axes.size(); ++i) {
        const TangentAxes& axes = cloud.axes[i];
        if (!is_finite(cloud.positions[i])) continue;
        radii.push_back(
            std::sqrt(length(vec_cast<double>(axes.u)) * length(vec_cast<double>(axes.v))));
    }
    if (radii.empty()) return 0.0;
    const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
    std::nth_element(radii.begin(), middle, radii.end());
    return *middle;
}

/// What a step would add, counted up to `most`.
std::uint64_t count_added(const PointCloud& cloud, double step, std::uint64_t most) {
    std::uint64_t added = 0;
    for (std::size_t i = 0; i < cloud.axes.size() && added <= most; ++i)
        if (is_finite(cloud.positions[i]))
            Steps(cloud.axes[i], step).for_each([&](int, int) { ++added; });
    return added;
}

/// A step that adds few enough; 0 if there is nothing to split.
double find_step(const PointCloud& cloud, const Context& context) {
    const auto there =
        static_cast<std::uint64_t>(std::count_if(cloud.positions.begin(), cloud.positions.end(),
                                                 [](const Vec3d& p) { return is_finite(p); }));
    const std::uint64_t most =
        std::min(kMostAdded * there, std::uint64_t{kInvalidIndex} - 1 - cloud.positions.size());
    double step = kLeastStep * median_radius(cloud);
    if (!(step > 0.0)) return 0.0;
    while (count_added(cloud, step, most) > most) {
        check_cancelled(context);
        step *= kStepGrowth;
    }
    return step;
}

/// Along one axis: a part is as wide as the splat where there is but one.
Vec3f part_axis(const Vec3f& axis, int steps, double step) {
    if (steps == 0) return axis;
    const double sigma = length(vec_cast<double>(axis));
    return vec_cast<float>(vec_cast<double>(axis) * std::min(1.0, kPartSigma * step / sigma));
}

float area_of(const TangentAxes& axes, float weight) {
    return static_cast<float>(2.0 * std::numbers::pi * length(vec_cast<double>(axes.u)) *
                              length(vec_cast<double>(axes.v)) * static_cast<double>(weight));
}

void append_copy(PointCloud& cloud, std::size_t i) {
    cloud.positions.push_back(cloud.positions[i]);
    if (!cloud.colors.empty()) cloud.colors.push_back(cloud.colors[i]);
    if (!cloud.radii.empty()) cloud.radii.push_back(cloud.radii[i]);
    if (!cloud.sensors.empty()) cloud.sensors.push_back(cloud.sensors[i]);
    cloud.normals.push_back(cloud.normals[i]);
    cloud.given_normals.push_back(cloud.given_normals[i]);
    cloud.weights.push_back(cloud.weights[i]);
    cloud.axes.push_back(cloud.axes[i]);
    cloud.areas.push_back(cloud.areas[i]);
    for (Channel& channel : cloud.channels)
        for (std::size_t k = 0; k < channel.num_components; ++k)
            channel.data.push_back(channel.data[i * channel.num_components + k]);
}

void split(PointCloud& cloud, std::size_t i, double step) {
    const TangentAxes whole = cloud.axes[i];
    const Steps steps(whole, step);
    if (steps.first == 0 && steps.second == 0) return;
    const double first = length(vec_cast<double>(whole.u)),
                 second = length(vec_cast<double>(whole.v));
    cloud.axes[i] = {part_axis(whole.u, steps.first, step), part_axis(whole.v, steps.second, step)};
    cloud.areas[i] = area_of(cloud.axes[i], cloud.weights[i]);
    steps.for_each([&](int along, int across) {
        append_copy(cloud, i);
        // In standard deviations
        const double a = along == 0 ? 0.0 : along * step / first;
        const double b = across == 0 ? 0.0 : across * step / second;
        cloud.positions.back() += vec_cast<double>(whole.u) * a + vec_cast<double>(whole.v) * b;
        cloud.weights.back() = static_cast<float>(static_cast<double>(cloud.weights[i]) *
                                                  portable_exp(-0.5 * (a * a + b * b)));
        cloud.areas.back() = area_of(cloud.axes.back(), cloud.weights.back());
    });
}

}  // namespace

std::uint64_t split_large_splats(PointCloud& cloud, const Context& context) {
    const std::size_t n = cloud.positions.size();
    const double step = find_step(cloud, context);
    if (step == 0.0) return 0;
    for (std::size_t i = 0; i < n; ++i)
        if (is_finite(cloud.positions[i])) split(cloud, i, step);
    return cloud.positions.size() - n;
}

}  // namespace pointbake
