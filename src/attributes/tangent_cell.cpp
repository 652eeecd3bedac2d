#include "attributes/tangent_cell.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace pointbake {
namespace {

constexpr double kPi = 3.141592653589793;
// Most cells are known from few neighbours; scan lines 16 times farther apart than their points
// need the many.
constexpr std::size_t kFewNeighbors = 25, kManyNeighbors = 64;
constexpr std::size_t kSides = 8;
constexpr std::size_t kMostCorners = kSides + kManyNeighbors;

class Polygon {
 public:
    /// A regular octagon.
    explicit Polygon(double inradius) {
        const double near = inradius, far = inradius * 0.41421356237309503;
        corners_ = {Vec2d{near, far},   Vec2d{far, near},   Vec2d{-far, near}, Vec2d{-near, far},
                    Vec2d{-near, -far}, Vec2d{-far, -near}, Vec2d{far, -near}, Vec2d{near, -far}};
        size_ = kSides;
    }

    double farthest2() const {
        double most = 0.0;
        for (std::size_t k = 0; k < size_; ++k)
            most = std::max(most, dot(corners_[k], corners_[k]));
        return most;
    }

    /// Keeps what is nearer to 0 than to q.
    void cut(Vec2d q) {
        const double limit = 0.5 * dot(q, q);
        std::array<Vec2d, kMostCorners> out;
        std::size_t count = 0;
        for (std::size_t k = 0; k < size_; ++k) {
            const Vec2d a = corners_[k], b = corners_[(k + 1) % size_];
            const double da = dot(a, q) - limit, db = dot(b, q) - limit;
            if (da <= 0.0) out[count++] = a;
            if ((da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0))
                out[count++] = a + (b - a) * (da / (da - db));
        }
        corners_ = out;
        size_ = count;
    }

    void measure(TangentCell& cell) const {
        double area = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
        for (std::size_t k = 0; k < size_; ++k) {
            const Vec2d a = corners_[k], b = corners_[(k + 1) % size_];
            const double twice = a.x * b.y - a.y * b.x;
            area += twice / 2.0;
            x += twice * (a.x + b.x) / 6.0;
            y += twice * (a.y + b.y) / 6.0;
            xx += twice * (a.x * a.x + a.x * b.x + b.x * b.x) / 12.0;
            yy += twice * (a.y * a.y + a.y * b.y + b.y * b.y) / 12.0;
            xy += twice * (2.0 * (a.x * a.y + b.x * b.y) + a.x * b.y + b.x * a.y) / 24.0;
        }
        cell.area = area;
        if (!(area > 0.0)) return;
        cell.uu = xx - x * x / area;
        cell.uv = xy - x * y / area;
        cell.vv = yy - y * y / area;
    }

 private:
    std::array<Vec2d, kMostCorners> corners_;
    std::size_t size_ = 0;
};

class CellCutter {
 public:
    CellCutter(const PointCloud& cloud, Index i)
        : cloud_(cloud), point_(i), facing_(cloud.normals[i]) {
        const Vec3d normal = vec_cast<double>(facing_);
        const Vec3d helper =
            std::fabs(normal.x) < 0.5 ? Vec3d{1.0, 0.0, 0.0} : Vec3d{0.0, 1.0, 0.0};
        cell_.u = normalized(cross(normal, helper));
        cell_.v = cross(normal, cell_.u);
    }

    /// The cell, if no farther point can cut it and no other sheet is near. (Among several, points
    /// that are few of their kind would stand for much.)
    bool cut_closed(std::span<const Neighbor> found) {
        if (num_of_this_sheet(found) + 1 < found.size()) return false;
        Polygon polygon(std::sqrt(found.back().squared_distance));
        cut(polygon, found);
        polygon.measure(cell_);
        return 4.0 * polygon.farthest2() <= found.back().squared_distance;
    }

    /// No farther than one spacing, that of all neighbours whichever sheet they are on.
    void cut_open(std::span<const Neighbor> found) {
        const std::size_t count = found.size() - 1;
        Polygon polygon(
            std::sqrt(kPi * found.back().squared_distance / static_cast<double>(count)));
        cut(polygon, found);
        polygon.measure(cell_);
    }

    const TangentCell& cell() const { return cell_; }

 private:
    bool is_of_this_sheet(const Neighbor& n) const {
        return n.squared_distance > 0.0 && !(dot(facing_, cloud_.normals[n.index]) < 0.0F);
    }

    std::size_t num_of_this_sheet(std::span<const Neighbor> found) const {
        return static_cast<std::size_t>(std::count_if(
            found.begin(), found.end(), [&](const Neighbor& n) { return is_of_this_sheet(n); }));
    }

    void cut(Polygon& polygon, std::span<const Neighbor> found) const {
        for (const Neighbor& n : found) {
            if (n.squared_distance > 4.0 * polygon.farthest2()) return;
            if (!is_of_this_sheet(n)) continue;
            const Vec3d d = cloud_.positions[n.index] - cloud_.positions[point_];
            const Vec2d q{dot(d, cell_.u), dot(d, cell_.v)};
            const double flat2 = dot(q, q);
            if (flat2 > 0.0) polygon.cut(q * std::sqrt(n.squared_distance / flat2));
        }
    }

    const PointCloud& cloud_;
    Index point_;
    Vec3f facing_;
    TangentCell cell_;
};

}  // namespace

TangentCell tangent_cell(const PointCloud& cloud, Index i, const KdTree& tree) {
    if (cloud.normals[i] == Vec3f{}) return {};
    std::array<Neighbor, kManyNeighbors> buffer;
    auto found = tree.nearest(cloud.positions[i], std::span(buffer).first(kFewNeighbors));
    if (!(found.back().squared_distance > 0.0)) return {};
    CellCutter cutter(cloud, i);
    if (cutter.cut_closed(found)) return cutter.cell();
    found = tree.nearest(cloud.positions[i], buffer);
    if (!cutter.cut_closed(found)) cutter.cut_open(found);
    return cutter.cell();
}

}  // namespace pointbake
