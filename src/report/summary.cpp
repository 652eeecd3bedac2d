#include <algorithm>
#include <cmath>

#include "core/kdtree.h"
#include "core/parallel.h"
#include "pointbake/report.h"

namespace pointbake {
namespace {

// What a whole conversion takes at its peak, measured on scans (docs/reliability.md).
constexpr std::uint64_t kBytesPerPoint = 1500, kBytesAtLeast = 100'000'000;
// Several points of a surface come from a splat.
constexpr std::uint64_t kBytesPerSplat = 6000, kBytesOfSplatsAtLeast = 200'000'000;

constexpr std::size_t kQueriesPerChunk = 4096;  // some milliseconds of nearest-neighbour queries

Quantiles nearest_distances(std::span<const Vec3d> positions, const Context& context) {
    if (positions.size() < 2) return {};
    const KdTree tree(positions);
    std::vector<double> distances(positions.size());
    parallel_for(context, positions.size(), kQueriesPerChunk,
                 [&](std::size_t begin, std::size_t end) {
                     std::array<Neighbor, 2> found;  // the point itself, and its neighbour
                     for (std::size_t i = begin; i < end; ++i) {
                         const auto nearest = tree.nearest(positions[i], found);
                         distances[i] = std::sqrt(nearest.back().squared_distance);
                     }
                 });
    return quantiles(std::move(distances));
}

/// Collects one attribute's range; values that are not finite are unknown.
class RangeCollector {
 public:
    RangeCollector(std::string name, std::string unit) {
        range_.name = std::move(name);
        range_.unit = std::move(unit);
        range_.low = HUGE_VAL;
        range_.high = -HUGE_VAL;
    }
    void add(double value) {
        if (!std::isfinite(value)) return;
        range_.low = std::min(range_.low, value);
        range_.high = std::max(range_.high, value);
        ++num_values_;
    }
    void add_vector(Vec3f v) {
        if (v == Vec3f{}) return;  // unknown
        for (std::size_t k = 0; k < 3; ++k) add(static_cast<double>(v[k]));
    }
    void finish_into(std::vector<AttributeRange>& out, std::uint64_t num_components) {
        if (num_values_ == 0) range_.low = range_.high = 0.0;
        range_.num_known = num_values_ / num_components;
        out.push_back(std::move(range_));
    }

 private:
    AttributeRange range_;
    std::uint64_t num_values_ = 0;
};

void add_vectors(std::vector<AttributeRange>& out, const char* name,
                 const std::vector<Vec3f>& values) {
    if (values.empty()) return;
    RangeCollector range(name, "");
    for (const Vec3f v : values) range.add_vector(v);
    range.finish_into(out, 3);
}

void add_scalars(std::vector<AttributeRange>& out, const std::string& name, const std::string& unit,
                 const std::vector<float>& values, std::uint64_t num_components) {
    if (values.empty()) return;
    RangeCollector range(name, unit);
    for (const float v : values) range.add(static_cast<double>(v));
    range.finish_into(out, num_components);
}

void add_colors(std::vector<AttributeRange>& out, const std::vector<Rgb16>& colors) {
    if (colors.empty()) return;
    constexpr double kStep = 257.0;  // 16-bit units of an 8-bit step
    RangeCollector range("colors", "8-bit sRGB");
    for (const Rgb16& c : colors)
        for (const std::uint16_t v : {c.r, c.g, c.b}) range.add(v / kStep);
    range.finish_into(out, 3);
}

}  // namespace

Quantiles quantiles(std::vector<double> values) {
    std::erase_if(values, [](double v) { return !std::isfinite(v); });
    if (values.empty()) return {};
    std::ranges::sort(values);
    const auto at = [&](double share) {
        return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
    };
    return {at(0.0), at(0.05), at(0.25), at(0.5), at(0.75), at(0.95), at(0.99), at(1.0)};
}

CloudSummary summarize(const PointCloud& cloud, const Context& context) {
    CloudSummary summary;
    summary.num_points = cloud.size();
    summary.frame = cloud.frame;
    for (const Vec3d& p : cloud.positions) summary.box.extend(p);
    summary.spacing = nearest_distances(cloud.positions, context);
    std::vector<AttributeRange>& out = summary.attributes;
    add_colors(out, cloud.colors);
    add_vectors(out, "normals", cloud.normals);
    add_scalars(out, "radii", "", cloud.radii, 1);
    add_scalars(out, "areas", "", cloud.areas, 1);
    if (!cloud.axes.empty()) {
        RangeCollector range("tangent axes", "");
        for (const TangentAxes& axes : cloud.axes) {
            range.add(static_cast<double>(length(axes.u)));
            range.add(static_cast<double>(length(axes.v)));
        }
        range.finish_into(out, 2);
    }
    add_vectors(out, "sensors", cloud.sensors);
    add_scalars(out, "weights", "", cloud.weights, 1);
    for (const Channel& channel : cloud.channels)
        add_scalars(out, channel.name, channel.unit, channel.data, channel.num_components);
    summary.are_splats = cloud.are_splats;
    return summary;
}

std::uint64_t predicted_memory(std::uint64_t num_points, bool are_splats) {
    if (are_splats) return kBytesOfSplatsAtLeast + kBytesPerSplat * num_points;
    return kBytesAtLeast + kBytesPerPoint * num_points;
}

}  // namespace pointbake
