#include "reconstruct/flat.h"

#include <algorithm>

#include "core/message.h"

namespace pointbake {
namespace {

// Thickness, as a share of the extent, below which points count as collinear or coplanar: what
// rounding leaves of a rotated plane in double is 1e-16, in float 1e-7. Scans are far rougher.
constexpr double kCollinear = 1e-12;
constexpr double kCoplanar = 1e-9;

}  // namespace

FlatFrame find_plane(std::span<const Vec3d> points) {
    Box box;
    for (const Vec3d& p : points) box.extend(p);
    const double extent = points.empty() ? 0.0 : box.diagonal();
    if (!(extent > 0))
        fail(ErrorCode::kDegenerate,
             "all {} points are in one place: a surface needs at least 3 different ones that are "
             "not on a line",
             points.size());
    // The point farthest from the first spans the line with it, the one farthest from that the
    // plane.
    FlatFrame frame;
    frame.origin = points[0];
    Vec3d along;
    for (const Vec3d& p : points)
        if (squared_length(p - frame.origin) > squared_length(along)) along = p - frame.origin;
    frame.u = normalized(along);
    Vec3d across;
    for (const Vec3d& p : points) {
        const Vec3d d = p - frame.origin, rest = d - frame.u * dot(d, frame.u);
        if (squared_length(rest) > squared_length(across)) across = rest;
    }
    if (length(across) <= kCollinear * extent)
        fail(ErrorCode::kDegenerate,
             "all {} points lie on a line: a surface needs at least 3 points "
             "that do not",
             points.size());
    frame.v = normalized(across);
    const Vec3d normal = cross(frame.u, frame.v);
    double thickness = 0.0;
    for (const Vec3d& p : points)
        thickness = std::max(thickness, std::abs(dot(p - frame.origin, normal)));
    frame.is_flat = thickness <= kCoplanar * extent;
    return frame;
}

std::vector<Vec3d> project(std::span<const Vec3d> points, const FlatFrame& frame) {
    std::vector<Vec3d> flat;
    flat.reserve(points.size());
    for (const Vec3d& p : points)
        flat.push_back({dot(p - frame.origin, frame.u), dot(p - frame.origin, frame.v), 0.0});
    return flat;
}

}  // namespace pointbake
