#include "model/decals.h"

namespace pointbake {
namespace {

using namespace palette;

// First-order distance to an ellipse, in its own units.
double ellipse(Vec2d p, Vec2d radii) {
    const Vec2d q{p.x / radii.x, p.y / radii.y};
    const double f = length(q);
    const double slope = length(Vec2d{q.x / radii.x, q.y / radii.y});
    return slope > 0.0 ? f * (f - 1.0) / slope : -std::min(radii.x, radii.y);
}

double circle(Vec2d p, Vec2d center, double radius) { return length(p - center) - radius; }

double segment(Vec2d p, Vec2d a, Vec2d b, double half_width) {
    const Vec2d d = b - a, q = p - a;
    return length(q - d * std::clamp(dot(q, d) / dot(d, d), 0.0, 1.0)) - half_width;
}

// Draws in the decal's own units.
struct Stencil {
    double size, share;
    Brush& brush;
    void fill(Vec3d color, double distance) const {
        brush.lay(color, share * coverage(distance * size));
    }
};

void paint_wing(Vec2d p, Vec2d root, Vec2d tip, const Stencil& stencil) {
    const Vec2d middle = (root + tip) * 0.5, axis = tip - root;
    const double l = length(axis);
    const Vec2d q = p - middle;
    const double d = ellipse({dot(q, axis) / l, cross(axis, q) / l}, {0.5 * l, 0.27 * l});
    stencil.fill(kNavy, d - 0.012);
    stencil.fill(kWhite, d + 0.012);
}

}  // namespace

void paint_bee(Vec2d at, double size, double share, Brush& brush) {
    if (share <= 0.0 || length(at) > 1.1 * size) return;
    const Stencil stencil{size, share, brush};
    const Vec2d p = at / size;
    constexpr Vec2d kTrail[] = {
        {-0.66, -0.10}, {-0.75, -0.20}, {-0.87, -0.22}, {-0.96, -0.13}, {-0.94, -0.01}};
    for (const Vec2d dot : kTrail) stencil.fill(kNavy, circle(p, dot, 0.017));
    paint_wing(p, {0.02, 0.16}, {-0.30, 0.58}, stencil);
    paint_wing(p, {0.10, 0.16}, {0.10, 0.68}, stencil);
    stencil.fill(kNavy, segment(p, {-0.40, -0.01}, {-0.56, -0.03}, 0.018));
    const double body = ellipse(p, {0.44, 0.27});
    stencil.fill(kNavy, body - 0.012);
    stencil.fill(kYellow, body + 0.012);
    for (const double x : {-0.25, -0.04, 0.17})
        stencil.fill(kNavy, std::max(body, std::abs(p.x - x) - 0.05));
    for (const Vec2d tip : {Vec2d{0.45, 0.40}, Vec2d{0.60, 0.36}}) {
        stencil.fill(kNavy, segment(p, {0.44, 0.14}, tip, 0.011));
        stencil.fill(kNavy, circle(p, tip, 0.030));
    }
    stencil.fill(kNavy, circle(p, {0.42, 0.03}, 0.185));
    stencil.fill(kWhite, circle(p, {0.48, 0.07}, 0.058));
    stencil.fill(kNavy, circle(p, {0.50, 0.07}, 0.027));
}

void paint_flower(Vec2d at, double size, double share, Brush& brush) {
    if (share <= 0.0 || length(at) > 1.1 * size) return;
    const Stencil stencil{size, share, brush};
    const Vec2d p = at / size;
    const double h = std::sqrt(0.5);
    const Vec2d petals[] = {{1, 0}, {h, h}, {0, 1}, {-h, h}, {-1, 0}, {-h, -h}, {0, -1}, {h, -h}};
    for (const Vec2d d : petals) {
        const Vec2d q{dot(p, d), cross(d, p)};
        const double petal = ellipse(q - Vec2d{0.56, 0.0}, {0.36, 0.20});
        stencil.fill(kRed, petal - 0.010);
        stencil.fill(kPink, petal + 0.010);
        stencil.fill(kRed, segment(q, {0.34, 0.0}, {0.62, 0.0}, 0.008));
    }
    stencil.fill(kOrange, circle(p, {}, 0.25));
    stencil.fill(kYellow, circle(p, {}, 0.19));
}

}  // namespace pointbake
