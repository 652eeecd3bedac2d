// From places on a mesh to surfels.
#include "pointbake/sample.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/color.h"
#include "core/message.h"
#include "core/parallel.h"
#include "pointbake/model.h"
#include "sample/blue_noise.h"
#include "sample/color_source.h"
#include "sample/covering.h"
#include "sample/ray_grid.h"

namespace pointbake {
namespace {

constexpr std::uint64_t kMostPoints = 500'000'000;  // five times as many still have an index
constexpr std::size_t kGrain = 1024;                // points per chunk
constexpr double kAreaTolerance = 1e-3;             // of the sum of areas; half of what is promised

void validate(const SampleOptions& options) {
    if (options.points < 1 || options.points > kMostPoints)
        fail(ErrorCode::kInvalidOption, "points is {}; 1 to {} are accepted", options.points,
             kMostPoints);
}

void validate(const TexturedMesh& model) {
    const Mesh& mesh = model.mesh;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const Index v : mesh.triangles[t])
            if (v >= mesh.positions.size())
                fail(ErrorCode::kInvalidInput, "triangle {} names vertex {}; the mesh has {}", t, v,
                     mesh.positions.size());
    const auto fits = [](std::size_t size, std::size_t expected) {
        return size == 0 || size == expected;
    };
    if (!fits(mesh.uvs.size(), mesh.triangles.size()) ||
        !fits(model.triangle_materials.size(), mesh.triangles.size()) ||
        !fits(mesh.colors.size(), mesh.positions.size()))
        fail(ErrorCode::kInvalidInput,
             "the mesh's texture coordinates, materials or colours are not one per triangle or "
             "vertex");
}

double surface_area(const Mesh& mesh) {
    double area = 0.0;
    for (Index t = 0; t < mesh.triangles.size(); ++t)
        area += 0.5 * length(TriangleFrame(mesh, t).normal());
    return area;
}

struct Samples {
    std::vector<SurfaceSample> places;
    double spacing = 0.0;  ///< for the choice of mip levels
};

/// With few points chance decides how many rays hit: then the areas are scaled to the surface's.
void correct_sum_of_areas_in_place(std::vector<SurfaceSample>& samples, double area) {
    double sum = 0.0;
    for (const SurfaceSample& s : samples) sum += static_cast<double>(s.area);
    if (std::fabs(sum - area) <= kAreaTolerance * area) return;
    const auto equal = static_cast<float>(area / static_cast<double>(samples.size()));
    for (SurfaceSample& s : samples)
        s.area = sum > 0.0 ? static_cast<float>(static_cast<double>(s.area) * (area / sum)) : equal;
}

Samples ldc_samples(const Mesh& mesh, const SampleOptions& options, double area,
                    const Context& context) {
    RayGridSamples grid = sample_on_ray_grid(mesh, options.points, context);
    report_progress(context, "sample", 0.3);
    cover_gaps_in_place(grid, mesh, context);
    correct_sum_of_areas_in_place(grid.samples, area);
    return {std::move(grid.samples), grid.spacing};
}

Vec3d normal_at(const Mesh& mesh, const SurfaceSample& s) {
    const Vec3d face = normalized(TriangleFrame(mesh, s.triangle).normal());
    if (mesh.normals.size() != mesh.positions.size()) return face;
    const Triangle& t = mesh.triangles[s.triangle];
    const Vec3d sum = vec_cast<double>(mesh.normals[t[0]]) * (1.0 - s.u - s.v) +
                      vec_cast<double>(mesh.normals[t[1]]) * s.u +
                      vec_cast<double>(mesh.normals[t[2]]) * s.v;
    const Vec3d smooth = normalized(sum);
    return is_finite(smooth) && squared_length(smooth) > 0.0 ? smooth : face;
}

/// Where the demo model's paint would be: relative to the box, its longest side from 0 to 1.
class PaintFrame {
 public:
    explicit PaintFrame(const Mesh& mesh) {
        Box box;
        for (const Triangle& t : mesh.triangles)
            for (const Index v : t) box.extend(mesh.positions[v]);
        const Vec3d extent = box.extent();
        low_ = box.low;
        size_ = std::max({extent.x, extent.y, extent.z});
    }
    Rgb16 color(Vec3d p, Vec3d normal) const { return paint_at((p - low_) / size_, normal); }

 private:
    Vec3d low_;
    double size_;
};

PointCloud make_cloud(const TexturedMesh& model, const Samples& samples, bool paint,
                      const Context& context) {
    const std::size_t n = samples.places.size();
    const ColorSource colors(model, context);
    const PaintFrame frame(model.mesh);
    const bool has_colors = paint || colors.has_colors();
    PointCloud cloud;
    cloud.positions.resize(n);
    cloud.normals.resize(n);
    cloud.radii.resize(n);
    cloud.areas.resize(n);
    if (has_colors) cloud.colors.resize(n);
    parallel_for(context, n, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const SurfaceSample& s = samples.places[i];
            const Vec3d normal = normal_at(model.mesh, s);
            cloud.positions[i] = position(model.mesh, s);
            cloud.normals[i] = vec_cast<float>(normal);
            cloud.areas[i] = s.area;
            cloud.radii[i] = std::sqrt(s.area);
            if (has_colors)
                cloud.colors[i] = rounded_to_8bit(paint ? frame.color(cloud.positions[i], normal)
                                                        : colors.color(s, samples.spacing));
        }
    });
    cloud.rows.resize(n);
    std::iota(cloud.rows.begin(), cloud.rows.end(), std::uint64_t{0});
    cloud.num_rows = n;
    return cloud;
}

}  // namespace

PointCloud sample(const TexturedMesh& mesh, const SampleOptions& options, const Context& context) {
    validate(options);
    validate(mesh);
    check_cancelled(context);
    const double area = surface_area(mesh.mesh);
    if (!(area > 0.0 && std::isfinite(area)))
        fail(ErrorCode::kDegenerate,
             "the mesh has no surface: {} triangles of area {}; a positive area is needed",
             mesh.mesh.triangles.size(), area);
    report_progress(context, "sample", 0.0);

    Samples samples;
    if (options.mode == SampleMode::kLdc) {
        samples = ldc_samples(mesh.mesh, options, area, context);
    } else {
        samples.places = sample_blue_noise(mesh.mesh, options.points, context);
        samples.spacing = std::sqrt(area / static_cast<double>(options.points));
    }
    report_progress(context, "sample", 0.8);
    PointCloud cloud = make_cloud(mesh, samples, options.paint, context);
    report_progress(context, "sample", 1.0);
    return cloud;
}

}  // namespace pointbake
