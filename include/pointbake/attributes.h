// Stage 2: what each point stands for: area, radius, normal, tangent axes.
#pragma once

#include "pointbake/context.h"
#include "pointbake/options.h"
#include "pointbake/types.h"

namespace pointbake {

struct AttributesOptions {
    Index neighbors = 16;
    template <class Field>
    static void describe(Field&& field) {
        field("neighbors", &AttributesOptions::neighbors,
              "neighbours a normal is estimated from (doubled while they lie on a line)");
    }
};

struct AttributesReport {
    double median_spacing = 0.0;  ///< cloud units, sqrt of the median area
    std::uint64_t num_estimated_normals = 0;
    std::uint64_t num_invalid_normals =
        0;  ///< the neighbourhood is a line or a point even at 64 neighbours
    std::uint64_t num_flipped_normals =
        0;                             ///< refine: turned to agree with the surface or the tree
    bool oriented_by_surface = false;  ///< else by a spanning tree over the neighbour graph
};

struct AttributesResult {
    PointCloud cloud;
    AttributesReport report;
};

/// Fills areas, radii and normals where the file has none: weighted covariance of the nearest
/// neighbours [Hoppe92, Pauly03] with a rank check; a normal that fails it is zero. Normals, radii
/// and areas that the cloud has are kept. Signs are not decided here. Expects what load_cloud hands
/// on: finite coordinates, no two points in one place. O(n log n). The cloud is taken by value and
/// handed back. Throws Error{kInvalidOption}.
AttributesResult estimate_attributes(PointCloud cloud, const AttributesOptions& options = {},
                                     const Context& context = {});

/// Second half, once there is a surface: orients every normal with the surface's outward side, and
/// takes areas (and radii that were estimated) from the surface triangles around a point, shared
/// evenly with the points within a spacing that are no vertices and nearest to it; all of them sum
/// to the surface's. Tangent axes are filled only where the cloud has none and the points are
/// clearly denser one way than the other. Points that are no vertices take the sign of the nearest
/// one; unknown normals of vertices become the surface's. With an empty surface, orients by a
/// minimum spanning tree of the neighbour graph [Hoppe92]. Throws Error{kInvalidOption}, and
/// Error{kInvalidInput} if the surface's vertex_points do not fit the cloud.
AttributesResult refine_attributes(PointCloud cloud, const DenseMesh& surface,
                                   const AttributesOptions& options = {},
                                   const Context& context = {});

/// Distances from each point to its nearest neighbour: median, and the 5 % and 95 % quantiles.
struct SpacingStats {
    double median = 0.0, p5 = 0.0, p95 = 0.0;
};
/// All 0 for fewer than two points. O(n log n).
SpacingStats spacing_stats(const PointCloud& cloud, const Context& context = {});

}  // namespace pointbake
