// Constructive solid geometry with smooth and sharp unions, after the distance functions of
// [Hart96] with the polynomial blend of [Quilez13]. Only + - * / and sqrt: the same bits
// everywhere.
#include "model/demo_shape.h"

#include <algorithm>
#include <cmath>

namespace pointbake {
namespace {

using M = DemoMeasures;

// Blends the two parts over a zone of width k; sharp for k = 0.
double join(double a, double b, double k = 0.0) {
    const double h = std::max(k - std::abs(a - b), 0.0);
    return std::min(a, b) - (k > 0.0 ? h * h / (4.0 * k) : 0.0);
}
double cut(double a, double b) { return std::max(a, b); }

double sphere(Vec3d p, double radius) { return length(p) - radius; }

double box(Vec3d p, Vec3d half) {
    const Vec3d q{std::abs(p.x) - half.x, std::abs(p.y) - half.y, std::abs(p.z) - half.z};
    const Vec3d out{std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)};
    return length(out) + std::min(std::max({q.x, q.y, q.z}), 0.0);
}

// Upright cylinder, |y| <= half.
double cylinder(Vec3d p, double radius, double half) {
    const double r = std::sqrt(p.x * p.x + p.z * p.z) - radius;
    const double y = std::abs(p.y) - half;
    const double ro = std::max(r, 0.0), yo = std::max(y, 0.0);
    return std::sqrt(ro * ro + yo * yo) + std::min(std::max(r, y), 0.0);
}

// Segment from a to b whose radius goes from ra to rb.
double cone(Vec3d p, Vec3d a, Vec3d b, double ra, double rb) {
    const Vec3d d = b - a;
    const double t = std::clamp(dot(p - a, d) / dot(d, d), 0.0, 1.0);
    return length(p - a - d * t) - (ra + (rb - ra) * t);
}

// Scaled sphere: exact on the surface, never more than the distance.
double ellipsoid(Vec3d p, Vec3d radii) {
    const double smallest = std::min({radii.x, radii.y, radii.z});
    return (length(Vec3d{p.x / radii.x, p.y / radii.y, p.z / radii.z}) - 1.0) * smallest;
}

double plinth(Vec3d p) {
    const double base = box(p - Vec3d{0.0, M::half_base.y, 0.0}, M::half_base);
    const Vec3d q = p - Vec3d{0.0, M::top - M::half_block.y, 0.0};
    const double block = box(q, M::half_block);
    // Planes at 45 degrees along the four upper edges.
    const double over = q.y - M::half_block.y + M::chamfer;
    const double side = std::max(std::abs(q.x) - M::half_block.x, std::abs(q.z) - M::half_block.z);
    const double chamfered = cut(block, (over + side) * std::sqrt(0.5));
    return join(base, chamfered);
}

double pot(Vec3d p) {
    const Vec3d q = p - M::pot;
    const double body = ellipsoid(q, M::pot_radii);
    const double foot = cylinder(p - Vec3d{M::pot.x, M::top + 0.02, M::pot.z}, 0.27, 0.04);
    const Vec3d lid_center{M::pot.x, M::lid, M::pot.z};
    const double collar = cylinder(p - lid_center, 0.285, 0.032);
    const double dome = cut(ellipsoid(p - lid_center, {0.245, 0.13, 0.245}), M::lid - p.y);
    return join(join(join(body, foot, 0.05), collar), dome);
}

double handle(Vec3d p) {
    // A ring in the plane z = pot.z, squeezed in x: the inner side is a saddle.
    const Vec3d q = p - Vec3d{M::pot.x - 0.44, M::pot.y + 0.03, M::pot.z};
    const double ring = std::sqrt(q.x * q.x + q.y * q.y) - 0.235;
    return std::sqrt(ring * ring + q.z * q.z) - M::handle_tube;
}

double spout(Vec3d p) {
    const Vec3d root{M::pot.x + 0.30, M::pot.y - 0.10, M::pot.z};
    const Vec3d knee{M::pot.x + 0.60, M::pot.y + 0.08, M::pot.z};
    const Vec3d lip{M::pot.x + 0.74, M::pot.y + 0.40, M::pot.z};
    const double lower = cone(p, root, knee, 0.15, 0.085);
    const double upper = cone(p, knee, lip, 0.085, 0.06);
    const double tube = cut(join(lower, upper, 0.12), p.y - (M::pot.y + 0.36));
    const double mouth = sphere(p - Vec3d{lip.x - 0.015, M::pot.y + 0.385, lip.z}, 0.036);
    return cut(tube, -mouth);
}

// Stem and cap; the cap's underside is hollow, so that it overhangs.
double mushroom(Vec3d p, Vec3d foot, double size) {
    const Vec3d q = (p - foot) / size;
    const double stem = cone(q, {0.0, -0.1, 0.0}, {0.0, 0.75, 0.0}, 0.16, 0.11);
    const double ball = ellipsoid(q - Vec3d{0.0, 0.62, 0.0}, {0.46, 0.36, 0.46});
    const double hollow = ellipsoid(q - Vec3d{0.0, 0.50, 0.0}, {0.42, 0.16, 0.42});
    const double cap = cut(cut(ball, 0.58 - q.y), -hollow);
    return join(stem, cap, 0.06) * size;
}

// A disc bent into a saddle, of constant thickness to first order, with a sharp rim, on a stalk.
double leaf(Vec3d p) {
    const Vec3d q = p - M::leaf;
    const double r = std::sqrt(q.x * q.x + q.z * q.z);
    // Beyond the rim the height field goes on as it is there: its slope stays bounded.
    const double s = r > M::leaf_radius ? M::leaf_radius / r : 1.0;
    const double x = q.x * s, z = q.z * s;
    const double height = M::leaf_bend * (x * x - z * z);
    const double slope2 = 4.0 * M::leaf_bend * M::leaf_bend * (x * x + z * z);
    const double sheet = std::abs(q.y - height) / std::sqrt(1.0 + slope2) - 0.5 * M::leaf_thickness;
    const double disc = cut(sheet, r - M::leaf_radius);
    const double stalk = cone(q, {0.0, -0.2, 0.0}, {0.0, -0.05, 0.0}, 0.07, 0.045);
    return join(disc, stalk, 0.05);
}

double vessel(Vec3d p) {
    const double body = join(join(pot(p), handle(p), 0.05), spout(p), 0.07);
    const double knob = mushroom(p, {M::pot.x, M::lid + 0.10, M::pot.z}, 0.20);
    return join(body, knob, 0.02);
}

// Parts that stand on the plinth, each with a sphere that holds it.
struct Part {
    double (*value)(Vec3d);
    Vec3d center;
    double radius;
};
constexpr Part kParts[] = {
    {vessel, {-0.16, 1.02, -0.12}, 0.80},
    {[](Vec3d p) { return mushroom(p, M::mushroom, 0.62); }, {0.62, 0.82, 0.30}, 0.40},
    {[](Vec3d p) { return mushroom(p, M::sprout, 0.30); }, {0.34, 0.68, 0.50}, 0.22},
    {leaf, {-0.70, 0.68, 0.42}, 0.32},
};
constexpr double kFillet = 0.035;  // where they meet the plinth

}  // namespace

double demo_shape(Vec3d p) {
    // A part that is farther than the nearest so far, blending zone included, changes nothing.
    constexpr double kReach = 0.1 + 2.0 * kFillet;
    double result = plinth(p);
    for (const Part& part : kParts) {
        const double far = std::max(0.0, result) + kReach + part.radius;
        if (squared_length(p - part.center) < far * far)
            result = join(result, part.value(p), kFillet);
    }
    return result;
}

Vec3d demo_shape_normal(Vec3d p) {
    // Far above the rounding of the function (1e-16), far below any detail (1e-2).
    constexpr double kStep = 1e-6;
    Vec3d gradient;
    for (std::size_t k = 0; k < 3; ++k) {
        Vec3d step;
        step[k] = kStep;
        gradient[k] = demo_shape(p + step) - demo_shape(p - step);
    }
    return normalized(gradient);
}

}  // namespace pointbake
