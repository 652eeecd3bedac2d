// Stage 4: a dense mesh becomes a light one, never farther from any point than the bound.
#pragma once

#include <optional>

#include "pointbake/context.h"
#include "pointbake/options.h"
#include "pointbake/types.h"

namespace pointbake {

struct SimplifyOptions {
    std::optional<Length> geometry_error =
        std::nullopt;  ///< unset: 0.1 %, or no bound if a number of triangles is given
    Index triangles = 0;
    bool keep_mesh = false;
    template <class Field>
    static void describe(Field&& field) {
        field("geometry-error", &SimplifyOptions::geometry_error,
              "largest distance of a kept point to the mesh: 0.1% of the bounding-box diagonal "
              "(the default), 0.002, "
              "2mm");
        field("triangles", &SimplifyOptions::triangles,
              "at most this many triangles; alone, it replaces the default bound");
        field("keep-mesh", &SimplifyOptions::keep_mesh, "keep the mesh as it is");
    }
};
/// Throws Error{kInvalidOption} for a bound that is no positive length.
void validate(const SimplifyOptions& options);

/// The bound that is asked for, or the default where it holds; none for a number of triangles
/// alone and for meshes that are kept.
std::optional<Length> bound_of(const SimplifyOptions& options);

/// Distances in cloud units. "points to mesh" is measured at every kept point; "mesh to surface" at
/// samples of the light mesh against the dense one, their spacing's slack added to the maximum.
struct DistanceStats {
    double mean = 0.0, rms = 0.0, max = 0.0;
};

struct SimplifyReport {
    double bound = 0.0;  ///< asked for, cloud units; infinite if only a budget was given
    bool bound_met =
        true;  ///< false when the budget could not be reached within the bound, or never was
    DistanceStats points_to_mesh;
    DistanceStats mesh_to_surface;
    Index num_triangles_before = 0, num_triangles = 0, num_vertices = 0;
    std::uint64_t num_collapses = 0, num_rejected_by_bound = 0, num_rejected_by_topology = 0,
                  num_rejected_by_shape = 0;
    std::uint64_t num_parts_removed =
        0;  ///< tiny parts left out because the budget serves the others better
    std::uint64_t num_off_surface = 0;  ///< points left out because the dense mesh itself is
                                        ///< farther than the bound, or their part was left out
};

struct SimplifyResult {
    Mesh mesh;  ///< without normals; every vertex used; no triangle of zero area
    std::vector<Index> point_triangles;  ///< per point of the cloud: the nearest triangle;
                                         ///< kInvalidIndex = off the surface
    std::vector<float> point_distances;  ///< per point, to that triangle
    SimplifyReport report;
};

/// Quadric edge collapse [Garland97] with area weights for the order and the attribution test for
/// the bound: a collapse is legal only if every point attributed to the triangles around it stays
/// within the bound. Link condition, flip, normal cone and shape checks; boundaries are kept;
/// no part changes its topology. Both limits hold: work stops at whichever comes first. Where a
/// budget alone drives, the shape checks give way at a price, and tiny parts go when their turn
/// comes. O(n log n). A closed 2-manifold stays one.
SimplifyResult simplify(const DenseMesh& dense, const PointCloud& cloud,
                        const SimplifyOptions& options = {}, const Context& context = {});

}  // namespace pointbake
