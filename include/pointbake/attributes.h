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
    std::uint64_t num_flipped_normals = 0;  ///< given normals turned to agree with the surface
    bool oriented_by_surface = false;       ///< else by a spanning tree over the neighbour graph
};

struct AttributesResult {
    PointCloud cloud;
    AttributesReport report;
};

/// Fills areas, radii and normals where the file has none: weighted covariance of the nearest
/// neighbours (algorithms: Hoppe 1992, Pauly 2002) with a rank check. Normals the file gives are
/// kept. Signs are not decided here. O(n log n). The cloud is taken by value and handed back.
AttributesResult estimate_attributes(PointCloud cloud, const AttributesOptions& options = {},
                                     const Context& context = {});

/// Second half, once there is a surface: orients every normal with the surface's outward side, and
/// takes areas and tangent axes from the surface triangles around a point. Points that are no
/// vertices take the sign of the nearest one. With an empty surface, orients by a minimum spanning
/// tree of the neighbour graph (Hoppe 1992).
AttributesResult refine_attributes(PointCloud cloud, const DenseMesh& surface,
                                   const AttributesOptions& options = {},
                                   const Context& context = {});

}  // namespace pointbake
