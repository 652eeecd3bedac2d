#include "reconstruct/implicit_method.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/adjacency.h"
#include "core/message.h"
#include "core/union_find.h"
#include "reconstruct/implicit.h"

namespace pointbake {
namespace {

double area_of(const Mesh& mesh) {
    double area = 0.0;
    for (const Triangle& t : mesh.triangles) {
        const Vec3d a = mesh.positions[t[0]];
        area += 0.5 * length(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a));
    }
    return area;
}

// What flat lids on all borders would add, as a share of the closed surface.
double share_of_lids(const Mesh& mesh) {
    const auto neighbors = triangle_neighbors(mesh.triangles);
    std::vector<std::pair<Index, Index>> sides;
    UnionFind loops(mesh.positions.size());
    for (std::size_t t = 0; t < neighbors.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (neighbors[t][k] != kInvalidIndex) continue;
            sides.emplace_back(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
            loops.unite(sides.back().first, sides.back().second);
        }
    }
    std::map<Index, Vec3d> lids;
    for (const auto& [a, b] : sides) {
        const Index loop = loops.find(a);
        const Vec3d origin = mesh.positions[loop];
        lids[loop] += cross(mesh.positions[a] - origin, mesh.positions[b] - origin) * 0.5;
    }
    double added = 0.0;
    for (const auto& [loop, area] : lids) added += length(area);
    return added > 0.0 ? added / (added + area_of(mesh)) : 0.0;
}

}  // namespace

ReconstructResult run_implicit(const PointCloud& cloud, Surface wanted, double max_added,
                               const Context& context) {
    if (cloud.normals.size() != cloud.size() || cloud.areas.size() != cloud.size())
        fail(ErrorCode::kInvalidInput, "the implicit method needs points with normals and areas");
    std::vector<float> spacing(cloud.size());
    std::transform(cloud.areas.begin(), cloud.areas.end(), spacing.begin(),
                   [](float area) { return std::sqrt(area); });
    const ImplicitInput input{cloud.positions, cloud.normals, spacing, cloud.noise};
    ReconstructResult result;
    ReconstructReport& report = result.report;
    Mesh& mesh = result.surface.mesh;
    bool is_closed = wanted == Surface::kWatertight;
    const ImplicitSurface surface(input, context);
    if (!is_closed) mesh = surface.mesh(false, context);
    if (wanted == Surface::kAuto && !mesh.triangles.empty()) {
        report.added_area_fraction = share_of_lids(mesh);
        is_closed = report.added_area_fraction <= max_added;
    }
    // An open surface without borders is the closed one.
    const bool is_whole = wanted == Surface::kAuto && report.added_area_fraction == 0.0 &&
                          volume(mesh.positions, mesh.triangles) > 0.0;
    if (is_closed && !is_whole) mesh = surface.mesh(true, context);
    if (mesh.triangles.empty())
        fail(ErrorCode::kDegenerate, "no surface found between the {} points", cloud.size());
    report.surface = is_closed ? Surface::kWatertight : Surface::kOpen;
    report.method = Method::kImplicit;
    report.reason = wanted == Surface::kAuto
                        ? fmt::format("{} {:.1f} % of the area (limit {:.0f} %)",
                                      is_closed ? "lids on all borders add only"
                                                : "lids on all borders would add",
                                      100 * report.added_area_fraction, 100 * max_added)
                        : "asked for";
    return result;
}

}  // namespace pointbake
