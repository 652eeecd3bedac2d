// From the rows of a file, whatever its format, to a cloud: bad rows out, equal points merged, the
// rest in Morton order.
#pragma once

#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

struct OrderedCloud {
    PointCloud cloud;
    /// The point that each input row became (also where it was merged into another row's);
    /// kInvalidIndex for dropped rows.
    std::vector<Index> point_of_row;
};

/// Takes a cloud with one entry per input row, `rows` and `num_rows` not yet filled. Rows with
/// non-finite coordinates go to `dropped`; those that stand there already, by row, stay as they
/// are. Rows with equal coordinates (-0 equals 0) are merged into the one with the lowest row:
/// colours are averaged in linear light; normals, radii, areas, weights, sensors and scalar or
/// vector channels are averaged; axes and categories are the lowest row's. Points are ordered along
/// a Morton curve, ties by coordinates: the order depends on the coordinates and the extent alone,
/// not on the order of the rows. O(n log n).
OrderedCloud order_cloud(PointCloud rows, const Context& context);

/// Side of the Morton grid's cells, a power of two: the extent spans at most 2^21 of them.
double morton_cell(const Box& box);

/// Place along the Morton curve over a grid anchored at the origin: 21 bits per axis, which wrap
/// around (negative coordinates come after positive ones).
std::uint64_t morton_code(Vec3d p, double cell);

}  // namespace pointbake
