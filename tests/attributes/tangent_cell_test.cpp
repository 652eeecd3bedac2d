#include "attributes/tangent_cell.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/hash.h"

namespace pointbake {
namespace {

// A lattice a by b in the plane z = height, turned by an angle; its middle point comes first.
void add_lattice(PointCloud& cloud, double a, double b, double angle, double height, float facing) {
    constexpr int kHalf = 12;
    const Vec3d u{std::cos(angle), std::sin(angle), 0.0}, v{-u.y, u.x, 0.0};
    const auto add = [&](int i, int j) {
        cloud.positions.push_back(u * (a * i) + v * (b * j) + Vec3d{0.0, 0.0, height});
        cloud.normals.push_back({0.0F, 0.0F, facing});
    };
    add(0, 0);
    for (int i = -kHalf; i <= kHalf; ++i)
        for (int j = -kHalf; j <= kHalf; ++j)
            if (i != 0 || j != 0) add(i, j);
}

TangentCell cell_of(const PointCloud& cloud, Index i) {
    return tangent_cell(cloud, i, KdTree(cloud.positions));
}

TEST(TangentCell, OfALatticeIsItsRectangleHoweverItIsTurned) {
    for (const auto& [a, b, angle] :
         {std::array{0.1, 0.1, 0.0}, {0.3, 0.1, 0.5}, {0.8, 0.1, 2.0}, {1.6, 0.1, 1.0}}) {
        const double area = a * b;
        PointCloud cloud;
        add_lattice(cloud, a, b, angle, 0.0, 1.0F);
        const TangentCell cell = cell_of(cloud, 0);
        EXPECT_NEAR(cell.area, area, 1e-12);
        // Second moments along the lattice's own axes.
        const Vec3d along{std::cos(angle), std::sin(angle), 0.0};
        const double x = dot(along, cell.u), y = dot(along, cell.v);
        EXPECT_NEAR(x * x * cell.uu + 2.0 * x * y * cell.uv + y * y * cell.vv, area * a * a / 12.0,
                    1e-12);
        EXPECT_NEAR(y * y * cell.uu - 2.0 * x * y * cell.uv + x * x * cell.vv, area * b * b / 12.0,
                    1e-12);
    }
}

TEST(TangentCell, OfAPointOnABorderEndsAtOneSpacing) {
    for (const bool is_turned : {false, true}) {
        PointCloud cloud;
        for (int i = 0; i < 20; ++i)
            for (int j = -10; j <= 10; ++j) {
                const double x = 0.1 * i, y = 0.1 * j;
                cloud.positions.push_back(is_turned ? Vec3d{y, x, 0.0} : Vec3d{x, y, 0.0});
                cloud.normals.push_back({0.0F, 0.0F, 1.0F});
            }
        // The 24 nearest of a point on the border fill half a disc: their spacing reads 1.4 times
        // too large.
        const TangentCell cell = cell_of(cloud, 10);
        EXPECT_GT(cell.area, 0.01 * (0.5 + 1.0));
        EXPECT_LT(cell.area, 0.01 * (0.5 + 1.5));
        // Its second moment is about its own middle, not about the point, which lies off it.
        const double across = std::max(cell.uu, cell.vv), along = std::min(cell.uu, cell.vv);
        const double width = cell.area / 0.1;
        EXPECT_NEAR(across, cell.area * width * width / 12.0, 0.05 * across);
        EXPECT_NEAR(along, cell.area * 0.01 / 12.0, 0.05 * along);
    }
}

TEST(TangentCell, IsNotCutByASheetThatFacesTheOtherWay) {
    for (const float other : {1.0F, -1.0F}) {
        PointCloud cloud;
        add_lattice(cloud, 0.1, 0.1, 0.0, 0.0, 1.0F);
        const auto first = static_cast<Index>(cloud.size());
        add_lattice(cloud, 0.1, 0.1, 0.0, 0.02, other);
        for (std::size_t i = first; i < cloud.size(); ++i)
            cloud.positions[i] += Vec3d{0.05, 0.02, 0.0};
        const double area = cell_of(cloud, 0).area;
        if (other < 0.0F) {
            EXPECT_NEAR(area, 0.01, 5e-4);
        } else {
            EXPECT_LT(area, 0.008);  // two scans of one surface
        }
    }
}

TEST(TangentCell, OfRandomPointsSumToTheArea) {
    // One sheet, and two that face apart and are nearer to each other than the points of either.
    for (const int sheets : {1, 2}) {
        PointCloud cloud;
        for (std::uint64_t i = 0; i < 4000; ++i) {
            const bool is_lower = sheets == 2 && i % 2 == 1;
            cloud.positions.push_back(
                {random_unit(3, 2 * i), random_unit(3, 2 * i + 1), is_lower ? -1e-3 : 0.0});
            cloud.normals.push_back({0.0F, 0.0F, is_lower ? -1.0F : 1.0F});
        }
        const KdTree tree(cloud.positions);
        double sum = 0.0;
        for (Index i = 0; i < cloud.size(); ++i) {
            const Vec3d p = cloud.positions[i];
            if (std::max(std::fabs(p.x - 0.5), std::fabs(p.y - 0.5)) < 0.4)
                sum += tangent_cell(cloud, i, tree).area;
        }
        EXPECT_NEAR(sum / (0.64 * sheets), 1.0, sheets == 1 ? 0.01 : 0.2);
    }
}

TEST(TangentCell, OfAPointWithoutANormalIsNone) {
    PointCloud cloud;
    add_lattice(cloud, 0.1, 0.1, 0.0, 0.0, 0.0F);
    EXPECT_EQ(cell_of(cloud, 0).area, 0.0);
}

}  // namespace
}  // namespace pointbake
