// Gaussian splats become points of a surface around them, with its faces: the method `opacity`.
#pragma once

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

struct SplatSurface {
    PointCloud cloud;  ///< a point per vertex, in the mesh's order, with its normal, colour and
                       ///< area; its row is that of the splat which shows most there, or beside it
    Mesh mesh;         ///< closed 2-manifold, counter-clockwise seen from outside
    double wanted_step = 0.0;  ///< edge of the grid's cubes that suits the splats' sizes
    double step = 0.0;         ///< what it is: more where that were too many cubes
};

/// Around what the splats make opaque, seen from outside, moved towards where they are seen in the
/// mean and smoothed [Taubin95]. Colours are those that a look along the normal shows: splats
/// composited from front to back [Kerbl23, eq. 3]. Pieces of less than a thousandth of the largest
/// one are dropped. Throws Error{kDegenerate} where nothing is opaque. The same for any number of
/// threads. Expects elliptical points with opacities. Linear in the splats and in the surface over
/// step^2.
SplatSurface splat_surface(const PointCloud& splats, const Context& context);

}  // namespace pointbake
