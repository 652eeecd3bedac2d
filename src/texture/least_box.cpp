#include "texture/least_box.h"

#include <algorithm>
#include <cmath>

namespace pointbake {
namespace {

// Corners of the convex hull, counter-clockwise [Andrew79].
std::vector<Vec2d> convex_hull(std::vector<Vec2d> points) {
    std::sort(points.begin(), points.end(),
              [](Vec2d a, Vec2d b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
    std::vector<Vec2d> hull;
    for (int side = 0; side < 2; ++side) {
        const std::size_t first = hull.size();
        for (const Vec2d p : points) {
            while (hull.size() >= first + 2 &&
                   cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0.0)
                hull.pop_back();
            hull.push_back(p);
        }
        hull.pop_back();
        std::reverse(points.begin(), points.end());
    }
    return hull;
}

}  // namespace

TurnedBox least_box(const std::vector<Vec2d>& points) {
    const std::vector<Vec2d> hull = convex_hull(points);
    TurnedBox best;
    double least = HUGE_VAL;
    for (std::size_t i = 0; i < std::max<std::size_t>(hull.size(), 1); ++i) {
        TurnedBox turned;
        if (!hull.empty()) {
            const Vec2d edge = hull[(i + 1) % hull.size()] - hull[i];
            if (length(edge) > 0.0) turned.along = edge / length(edge);
        }
        turned.low = {HUGE_VAL, HUGE_VAL};
        turned.high = {-HUGE_VAL, -HUGE_VAL};
        for (const Vec2d x : hull.empty() ? points : hull) {
            const Vec2d p = turned.place(x);
            turned.low = {std::min(turned.low.x, p.x), std::min(turned.low.y, p.y)};
            turned.high = {std::max(turned.high.x, p.x), std::max(turned.high.y, p.y)};
        }
        if (turned.area() < least) least = turned.area(), best = turned;
    }
    return best;
}

}  // namespace pointbake
