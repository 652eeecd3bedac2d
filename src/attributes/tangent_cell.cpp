#include "attributes/tangent_cell.h"

#include <array>
#include <cmath>

namespace pointbake {
namespace {

constexpr double kPi = 3.141592653589793;
// A regular polygon whose corners are as far as its area's square root times this: with eight
// corners its sides are a spacing away.
constexpr std::size_t kSides = 8;
constexpr std::size_t kMostCorners = kSides + kCellNeighbors;

class Polygon {
 public:
    explicit Polygon(double inradius) {
        // Corners at 22.5 degrees and so on.
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

}  // namespace

TangentCell tangent_cell(const PointCloud& cloud, Index i, std::span<const Neighbor> neighbors) {
    TangentCell cell;
    const Vec3f facing = cloud.normals[i];
    const Vec3d normal = vec_cast<double>(facing), p = cloud.positions[i];
    const double radius2 = neighbors.back().squared_distance;
    if (!(radius2 > 0.0) || facing == Vec3f{}) return cell;
    const Vec3d helper = std::fabs(normal.x) < 0.5 ? Vec3d{1.0, 0.0, 0.0} : Vec3d{0.0, 1.0, 0.0};
    cell.u = normalized(cross(normal, helper));
    cell.v = cross(normal, cell.u);
    const double spacing = std::sqrt(kPi * radius2 / static_cast<double>(neighbors.size() - 1));
    Polygon polygon(spacing);
    for (const Neighbor& n : neighbors) {
        if (n.index == i || n.squared_distance == 0.0) continue;
        if (n.squared_distance > 4.0 * polygon.farthest2()) break;
        if (dot(facing, cloud.normals[n.index]) < 0.0F) continue;
        const Vec3d d = cloud.positions[n.index] - p;
        const Vec2d q{dot(d, cell.u), dot(d, cell.v)};
        const double flat2 = dot(q, q);
        if (flat2 > 0.0) polygon.cut(q * std::sqrt(n.squared_distance / flat2));
    }
    polygon.measure(cell);
    return cell;
}

}  // namespace pointbake
