// The mean under the hat function of each vertex: as wide as the mesh is coarse, so that what the
// triangles cannot show is averaged as texels average it.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/adjacency.h"
#include "core/color.h"
#include "core/message.h"
#include "core/parallel.h"
#include "pointbake/texture.h"
#include "texture/visibility.h"

namespace pointbake {
namespace {

/// One seen point: its triangle's corners weigh so much there.
struct Sample {
    Index triangle, point;
    std::array<float, 3> weights;
};

std::vector<Sample> seen_samples(const Mesh& mesh, const PointCloud& cloud,
                                 std::span<const Index> owners, const TextureOptions& options,
                                 const Context& context) {
    const auto neighbors = triangle_neighbors(mesh.triangles);
    const Shell shell(mesh, options.projection, context);
    Footprints prints = project_points(mesh, cloud, owners, shell, neighbors, Kernel{}, context);
    hide_covered_in_place(prints, cloud, shell, context);
    std::vector<Sample> samples;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const TriangleFrame& frame = shell.frame(t);
        if (!(frame.area() > 0.0)) continue;
        for (const Footprint& f : prints.of(t)) {
            if (f.hidden) continue;
            const std::array<double, 3> b = frame.barycentric(vec_cast<double>(f.center));
            std::array<float, 3> weights{};
            for (std::size_t k = 0; k < 3; ++k)
                weights[k] = static_cast<float>(std::clamp(b[k], 0.0, 1.0));
            samples.push_back({t, f.point, weights});
        }
    }
    return samples;
}

/// Sums of weighted linear light.
struct Mean {
    Vec3f sum;
    float weight = 0.0F;
    void add(Vec3f value, float w) { sum += value * w, weight += w; }
    Vec3f value() const { return sum / weight; }
};

/// From the vertices that have a colour to their neighbours, ring after ring.
Index spread_in_place(std::vector<Mean>& means, std::span<const Triangle> triangles,
                      const Context& context) {
    Index num_filled = 0;
    for (bool has_changed = true; has_changed;) {
        check_cancelled(context);
        has_changed = false;
        std::vector<Mean> ring(means.size());
        for (const Triangle& t : triangles)
            for (const Index v : t)
                for (const Index u : t)
                    if (means[v].weight == 0.0F && means[u].weight > 0.0F)
                        ring[v].add(means[u].value(), 1.0F);
        for (std::size_t v = 0; v < means.size(); ++v) {
            if (ring[v].weight == 0.0F) continue;
            means[v] = {ring[v].value(), 1.0F};
            ++num_filled, has_changed = true;
        }
    }
    return num_filled;
}

Rgb16 coded(Vec3f linear) {
    const auto code = [](float v) {
        const double srgb = linear_to_srgb_exact(static_cast<double>(v));
        return static_cast<std::uint16_t>(srgb * 65535.0 + 0.5);
    };
    return {code(linear.x), code(linear.y), code(linear.z)};
}

Vec3f steps(Vec3f linear) {
    return {linear_to_srgb255(linear.x), linear_to_srgb255(linear.y), linear_to_srgb255(linear.z)};
}

/// What is shown against the points' own colours, over all seen points.
void measure_into(VertexColors& out, const Mesh& mesh, const PointCloud& cloud,
                  std::span<const Sample> samples) {
    std::vector<float> errors;
    double squares = 0.0;
    for (const Sample& s : samples) {
        Mean shown;
        for (std::size_t k = 0; k < 3; ++k)
            shown.add(to_linear(out.colors[mesh.triangles[s.triangle][k]]), s.weights[k]);
        const Vec3f d = steps(shown.value()) - steps(to_linear(cloud.colors[s.point]));
        const double square = static_cast<double>(squared_length(d)) / 3.0;
        squares += square;
        errors.push_back(static_cast<float>(std::sqrt(square)));
    }
    if (errors.empty()) return;
    out.rms = std::sqrt(squares / static_cast<double>(errors.size()));
    const auto p99 = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() * 99 / 100);
    std::nth_element(errors.begin(), p99, errors.end());
    out.p99 = static_cast<double>(*p99);
}

}  // namespace

VertexColors color_vertices(const Mesh& mesh, const PointCloud& cloud,
                            std::span<const Index> owners, const TextureOptions& options,
                            const Context& context) {
    if (owners.size() != cloud.size() || cloud.areas.size() != cloud.size() ||
        cloud.colors.size() != cloud.size())
        fail(ErrorCode::kInvalidInput,
             "colours of vertices need owners, areas and colours of all {} "
             "points",
             cloud.size());
    const std::vector<Sample> samples = seen_samples(mesh, cloud, owners, options, context);
    std::vector<Mean> means(mesh.positions.size());
    for (const Sample& s : samples)
        for (std::size_t k = 0; k < 3; ++k)
            means[mesh.triangles[s.triangle][k]].add(to_linear(cloud.colors[s.point]),
                                                     s.weights[k] * cloud.areas[s.point]);
    VertexColors out;
    out.num_unseen = spread_in_place(means, mesh.triangles, context);
    for (const Mean& mean : means)
        out.colors.push_back(mean.weight > 0.0F ? coded(mean.value()) : Rgb16{});
    measure_into(out, mesh, cloud, samples);
    return out;
}

}  // namespace pointbake
