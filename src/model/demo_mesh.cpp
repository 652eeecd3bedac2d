// The demo model's surface.
#include "model/contour.h"
#include "model/demo_shape.h"
#include "pointbake/model.h"

namespace pointbake {

Mesh demo_mesh() {
    // 1/64 of a unit: two cells and more through the thinnest part. The lattice keeps off all the
    // planes of the plinth.
    constexpr double kSpacing = 1.0 / 64.0;
    const ContourGrid grid{{-1.0307, -0.0411, -0.7309}, kSpacing, {17, 16, 12}};
    return contour({&demo_shape, &demo_shape_normal}, grid);
}

}  // namespace pointbake
