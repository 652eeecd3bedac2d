// Which colours belong side by side: what mip levels mix is then alike.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "pointbake/patch.h"

namespace pointbake {

/// Per shape its place in an order in which those of like colour follow each other: the leaves of a
/// tree of medians. O(n log n).
std::vector<Index> order_by_color(std::span<const PatchShape> shapes);

/// Rows that run through the colours of their shapes from left to right.
class Tints {
 public:
    /// Mean colours of equal parts of a row, left to right.
    using Row = std::array<Vec3f, 64>;

    explicit Tints(std::span<const PatchShape> shapes);

    /// Whether all shapes have the same colour: no place is better than another.
    bool are_one() const { return scale_ == 0.0F; }
    /// The row of some of the shapes. O(n log n) of these.
    Row row_of(std::vector<Index> shapes) const;

    /// How unlike a shape's colour is to what belongs at x, 0 at the left end of the row and 1 at
    /// its right: a third in the mean over all shapes and places; 0 if all colours are the same.
    double distance(Index shape, const Row& row, double x) const;

 private:
    std::vector<Vec3f> colors_;  // per shape
    std::vector<float> sizes_;   // in texels
    std::vector<Index> order_;   // places
    float scale_ = 0.0F;
};

}  // namespace pointbake
