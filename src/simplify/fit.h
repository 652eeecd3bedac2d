// The last word on the vertices: least-squares positions and edge flips for a given connectivity.
#pragma once

#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"
#include "simplify/attribution.h"
#include "simplify/surface.h"

namespace pointbake {

/// A light mesh without unused vertices, and who belongs to which triangle.
struct FitMesh {
    std::vector<Vec3d> positions;
    std::vector<VertexKind> kinds;
    std::vector<Triangle> triangles;
    std::vector<Index> owners;  ///< per point; kInvalidIndex = off the surface
};

/// Moves vertices and flips edges so that the sum of weighted squared distances of points falls.
/// No point that was within the limit leaves it; topology stays; triangles do not turn over.
void fit_in_place(FitMesh& mesh, const Attribution& points, double squared_limit,
                  const Context& context);

/// Lets each point walk to nearer triangles among those around its owner until there is none.
void walk_to_nearest_in_place(FitMesh& mesh, const Attribution& points, const Context& context);

}  // namespace pointbake
