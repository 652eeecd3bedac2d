// The demo model as a signed function of space, and the measures that its paint is laid out by.
#pragma once

#include "pointbake/vec.h"

namespace pointbake {

/// Where things stand, in model units. The base of the plinth fills x in [-1, 1], z in [-0.7, 0.7]
/// and stands on y = 0.
struct DemoMeasures {
    static constexpr Vec3d half_base{1.0, 0.05, 0.7};     ///< bottom slab
    static constexpr Vec3d half_block{0.95, 0.27, 0.65};  ///< block with the lettering
    static constexpr double top = 0.54;                   ///< upper face of the plinth
    static constexpr double chamfer = 0.035;              ///< cut off the block's upper edges
    static constexpr Vec3d pot{-0.16, 0.93, -0.12};       ///< centre of the pot's body
    static constexpr Vec3d pot_radii{0.46, 0.38, 0.46};
    static constexpr double lid = 1.235;          ///< height of the lid's rim
    static constexpr double handle_tube = 0.034;  ///< radius of the handle: the model's thinnest
    static constexpr Vec3d mushroom{0.62, 0.54, 0.30};
    static constexpr Vec3d sprout{0.34, 0.54, 0.50};
    static constexpr Vec3d leaf{-0.70, 0.72, 0.42};  ///< centre of the saddle-shaped leaf
    static constexpr double leaf_radius = 0.24;
    static constexpr double leaf_thickness = 0.07;
    static constexpr double leaf_bend = 1.4;  ///< height = bend (x^2 - z^2): curvature +-2 bend
};

/// Negative inside, positive outside, changing by at most 1.1 per unit of length: a lower bound of
/// the distance to the surface up to that factor.
double demo_shape(Vec3d p);

/// Outward unit normal of the level set through p.
Vec3d demo_shape_normal(Vec3d p);

}  // namespace pointbake
