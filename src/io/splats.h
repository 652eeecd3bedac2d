// Gaussian splats [Kerbl23, Huang24] as surfels: the thin axis is the normal, the two others are
// the axes of the ellipse.
#pragma once

#include <array>
#include <vector>

#include "io/point_table.h"
#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// One entry per splat.
struct SplatShapes {
    std::vector<Vec3f> sigmas;                    ///< standard deviations; 2-D splats: third is 0
    std::vector<std::array<float, 4>> rotations;  ///< quaternions w, x, y, z of any length
    std::vector<float> opacities;                 ///< 0 to 1
};

/// Gives the points normals of unknown sign, axes, areas and weights. Splats that are faint, very
/// large or needles are dropped and counted in a note; normals of those that are not flat are left
/// unknown. They have y down, as the 2023 code has.
void make_surfels(PointRows& points, const SplatShapes& shapes, const Context& context);

/// Takes the shapes out of the channels scale_0 ..., rot_0 ..., opacity as the 2023 code writes
/// them: logarithms, and a logit. Leaves everything as it is and returns false if some are missing.
bool take_shapes(PointCloud& cloud, SplatShapes& shapes, const Context& context);

/// Degree 0 of the spherical harmonics as a colour.
Rgb16 color_of_harmonic(Vec3d f_dc);
/// sRGB-coded colour from 0 to 1; clamps.
Rgb16 color_of_unit(Vec3d color);

/// exp(), the same bits on every machine; relative error below 1e-14 where it is finite.
double portable_exp(double x);

}  // namespace pointbake
