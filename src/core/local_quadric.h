// Quadrics over the tangent plane of a point, fitted to more and more neighbours.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "core/kdtree.h"
#include "pointbake/vec.h"

namespace pointbake {

/// A place, a normal and two tangents, all orthonormal.
struct TangentFrame {
    Vec3d origin, u, v, normal;
};

/// Frame of the plane through the neighbours' mean, at `p`. None if they lie on a line.
std::optional<TangentFrame> tangent_frame(std::span<const Vec3d> positions, Vec3d p,
                                          std::span<const Neighbor> neighbors);

/// Height z = c0 + c1 x + c2 y + c3 x^2 + c4 x y + c5 y^2 over the frame, by least squares.
struct Quadric {
    std::array<double, 6> c{};
    double variance = 0.0;  ///< of the heights about the quadric, freedom taken into account
    double leverage = 0.0;  ///< variance of c0 / variance of a height
};

/// Sums of a least squares fit; points are added in any number of steps. Lengths are divided by
/// `scale` inside.
class QuadricFit {
 public:
    QuadricFit(const TangentFrame& frame, double scale) : frame_(frame), scale_(scale) {}
    void add(Vec3d q, double weight = 1.0);
    /// None if the points do not determine a quadric.
    std::optional<Quadric> solve() const;

 private:
    TangentFrame frame_;
    double scale_;
    std::array<std::array<double, 6>, 6> normal_{};  // lower triangle
    std::array<double, 6> right_{};
    double squares_ = 0.0, weights_ = 0.0;
};

}  // namespace pointbake
