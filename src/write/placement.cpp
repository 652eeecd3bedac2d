#include "write/placement.h"

#include <algorithm>
#include <cmath>

#include "core/message.h"

namespace pointbake {
namespace {

/// Squared distance between a point and its float.
double squared_loss(Vec3d p, Vec3d translation) {
    const Vec3d q = p - translation;
    return squared_length(vec_cast<double>(vec_cast<float>(q)) - q);
}

Vec3d rounded_center(const Box& box) {
    const Vec3d extent = box.extent();
    const double largest = std::max({extent.x, extent.y, extent.z});
    if (!(largest > 0.0)) return box.center();
    int exponent = 0;
    std::frexp(largest, &exponent);
    const double step = std::ldexp(1.0, exponent);  // largest < step <= 2 largest
    const Vec3d c = box.center();
    return {std::floor(c.x / step + 0.5) * step, std::floor(c.y / step + 0.5) * step,
            std::floor(c.z / step + 0.5) * step};
}

Box box_of(std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
    Box box;
    for (const Triangle& t : triangles)
        for (const Index v : t) box.extend(positions[v]);
    return box;
}

void check_floats(std::span<const Vec3f> floats, std::span<const Vec3d> positions,
                  std::span<const Triangle> triangles) {
    for (const Triangle& t : triangles)
        for (const Index v : t)
            if (!is_finite(floats[v]))
                fail(ErrorCode::kLimit,
                     "vertex {} at ({}, {}, {}) does not fit a 32-bit float: scale the input down",
                     v, positions[v].x, positions[v].y, positions[v].z);
}

double farthest_coordinate(const Box& box) {
    double far = 0.0;
    for (std::size_t k = 0; k < 3; ++k)
        far = std::max({far, std::fabs(box.low[k]), std::fabs(box.high[k])});
    return far;
}

}  // namespace

Placement32 place_as_floats(std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
    const Box box = box_of(positions, triangles);
    double loss = 0.0;
    for (const Triangle& t : triangles)
        for (const Index v : t) loss = std::max(loss, squared_loss(positions[v], {}));
    Placement32 placement;
    const double allowed = kMaxFloatLoss * box.diagonal();
    if (!(loss <= allowed * allowed)) placement.translation = rounded_center(box);

    placement.positions.reserve(positions.size());
    for (const Vec3d& p : positions)
        placement.positions.push_back(vec_cast<float>(p - placement.translation));
    check_floats(placement.positions, positions, triangles);
    return placement;
}

Placement32 place_on_grid(std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
    constexpr int kLargestExponent = 80;
    constexpr double kMostSteps = 1 << 22;
    const Box box = box_of(positions, triangles);
    Placement32 placement;
    // Rounding moves each coordinate by half a step.
    placement.exponent = std::ilogb(2.0 / std::sqrt(3.0) * kMaxFloatLoss * box.diagonal());
    if (std::abs(placement.exponent) > kLargestExponent)
        fail(ErrorCode::kLimit, "--compress: an extent of {} is out of range: scale the input",
             box.diagonal());
    const double step = std::ldexp(1.0, placement.exponent);
    if (farthest_coordinate(box) > kMostSteps * step) placement.translation = rounded_center(box);
    for (const Vec3d& p : positions) {
        Vec3d q = p - placement.translation;
        for (std::size_t k = 0; k < 3; ++k) q[k] = std::floor(q[k] / step + 0.5) * step;
        placement.positions.push_back(vec_cast<float>(q));
    }
    check_floats(placement.positions, positions, triangles);
    return placement;
}

bool are_floats(std::span<const Vec3d> positions) {
    // A NaN stays a NaN in a float.
    const auto is_float = [](double v) {
        return std::isnan(v) || static_cast<double>(static_cast<float>(v)) == v;
    };
    return std::all_of(positions.begin(), positions.end(), [&](const Vec3d& p) {
        return is_float(p.x) && is_float(p.y) && is_float(p.z);
    });
}

}  // namespace pointbake
