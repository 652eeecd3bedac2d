#include "reconstruct/holes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/adjacency.h"

namespace pointbake {
namespace {

// A square of n x n vertices, one apart, without the triangles for which `is_gone` holds at the
// centroid.
struct Sheet {
    std::vector<Vec3d> points;
    std::vector<float> spacing;
    IndexedSurface surface;
    std::optional<double> size = {};
    Index num_filled = 0;

    template <class Gone>
    Sheet(Index n, Gone&& is_gone) {
        for (Index v = 0; v < n * n; ++v) {
            points.push_back({static_cast<double>(v % n), static_cast<double>(v / n), 0.0});
            spacing.push_back(1.0F);
            surface.vertex_points.push_back(v);
        }
        for (Index v = 0; v + n < n * n; ++v) {
            if (v % n == n - 1) continue;
            for (const Triangle& t : {Triangle{v, v + 1, v + n + 1}, Triangle{v, v + n + 1, v + n}})
                if (!is_gone((points[t[0]] + points[t[1]] + points[t[2]]) / 3.0))
                    surface.triangles.push_back(t);
        }
    }

    Topology fill() {
        num_filled = fill_holes_in_place(points, spacing, {size, nullptr}, surface, {});
        const Topology t = topology(points.size(), surface.triangles);
        EXPECT_EQ(t.num_nonmanifold_edges + t.num_nonmanifold_vertices, 0U);
        return t;
    }

    double area() const {
        double sum = 0.0;
        for (const Triangle& t : surface.triangles) {
            const double z = cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]).z;
            EXPECT_GT(z, 0.0);
            sum += 0.5 * z;
        }
        return sum;
    }
};

TEST(Holes, AreFilledFlatWhereTheSheetIsFlat) {
    Sheet sheet(20, [](Vec3d c) { return length(c - Vec3d{9, 9, 0}) < 2.1; });
    EXPECT_LT(sheet.area(), 19 * 19 - 8);
    EXPECT_EQ(sheet.fill().num_boundary_loops, 1U);  // the sheet's own rim
    EXPECT_NEAR(sheet.area(), 19 * 19, 1e-9);
}

TEST(Holes, WideOnesStayOpen) {
    Sheet sheet(30, [](Vec3d c) { return length(c - Vec3d{14, 14, 0}) < 5.0; });
    const double before = sheet.area();
    EXPECT_EQ(sheet.fill().num_boundary_loops, 2U);
    EXPECT_EQ(sheet.area(), before);
}

TEST(Holes, WideOnesAreFilledIfTheirSizeIsGiven) {
    for (const double radius : {5.0, 12.0, 25.0}) {
        for (const double size : {1.9 * radius, 2.1 * radius + 2.0}) {
            Sheet sheet(120, [&](Vec3d c) { return length(c - Vec3d{60, 60, 0}) < radius; });
            const double before = sheet.area();
            sheet.size = size;
            const bool is_filled = size > 2.0 * radius;
            EXPECT_EQ(sheet.fill().num_boundary_loops, is_filled ? 1U : 2U);
            EXPECT_EQ(sheet.num_filled, is_filled ? 1U : 0U);
            EXPECT_NEAR(sheet.area(), is_filled ? 119.0 * 119.0 : before, 1e-6);
        }
    }
}

TEST(Holes, OfSizeZeroAreNone) {
    Sheet sheet(20, [](Vec3d c) { return length(c - Vec3d{9, 9, 0}) < 2.1; });
    sheet.size = 0.0;
    EXPECT_EQ(sheet.fill().num_boundary_loops, 2U);
    EXPECT_EQ(sheet.num_filled, 0U);
}

TEST(Holes, OfHundredsOfEdgesAreFilledWithoutFolds) {
    // A star of 8 deep rays: few chords lie inside.
    Sheet sheet(260, [](Vec3d c) {
        const Vec3d d = c - Vec3d{130, 130, 0};
        const double angle = std::atan2(d.y, d.x);
        return length(d) < 40.0 + 22.0 * std::cos(8.0 * angle);
    });
    sheet.size = 150.0;
    const Topology t = topology(sheet.points.size(), sheet.surface.triangles);
    EXPECT_GT(t.num_boundary_edges, 4U * 259U + 400U);
    EXPECT_EQ(sheet.fill().num_boundary_loops, 1U);
    EXPECT_NEAR(sheet.area(), 259.0 * 259.0, 1e-6);  // each triangle's is positive
}

TEST(Holes, OfABentSheetAreFilledSmoothly) {
    constexpr double kRadius = 60.0;  // of a sphere
    Sheet sheet(80, [&](Vec3d c) { return length(c - Vec3d{40, 40, 0}) < 20.0; });
    for (Vec3d& p : sheet.points)
        p.z = std::sqrt(kRadius * kRadius - squared_length(Vec3d{p.x - 40, p.y - 40, 0}));
    sheet.size = 45.0;
    EXPECT_EQ(sheet.fill().num_boundary_loops, 1U);
    EXPECT_NEAR(sheet.area(), 79.0 * 79.0, 1e-6);  // seen from above: none is turned over
}

TEST(Holes, RimsStayOpenForAnySize) {
    Sheet sheet(40, [](Vec3d c) { return length(c - Vec3d{20, 20, 0}) < 5.0; });
    sheet.size = 1e6;
    EXPECT_EQ(sheet.fill().num_boundary_loops, 1U);
    EXPECT_EQ(sheet.num_filled, 1U);
    EXPECT_NEAR(sheet.area(), 39.0 * 39.0, 1e-6);
}

TEST(Holes, RimsOfSmallSheetsStayOpen) {
    for (Index n : {5U, 7U}) {
        Sheet sheet(n, [](Vec3d) { return false; });
        EXPECT_EQ(sheet.fill().num_boundary_loops, 1U);
        EXPECT_EQ(sheet.area(), (n - 1.0) * (n - 1.0));
    }
}

TEST(Holes, NeverMakeAnEdgeOfThreeTriangles) {
    // Two deep pits on both sides of the edge 1-3: their common rim can only be closed over 0-2.
    std::vector<Vec3d> points{{0, 0, 0}, {1, 0, 0},      {1, 1, 0},
                              {0, 1, 0}, {0.3, 0.3, -4}, {0.7, 0.7, -4}};
    IndexedSurface surface{{0, 1, 2, 3, 4, 5},
                           {{0, 1, 4}, {1, 3, 4}, {3, 0, 4}, {1, 2, 5}, {2, 3, 5}, {3, 1, 5}}};
    fill_holes_in_place(points, std::vector<float>(points.size(), 1.0F), {}, surface, {});
    EXPECT_TRUE(topology(points.size(), surface.triangles).is_closed_manifold());
}

TEST(Holes, CopiesOfOnePointAreNotJoined) {
    // A hole pinched together at its middle: vertices 7 and 9 lie at one place.
    Sheet sheet(20,
                [](Vec3d c) { return std::fabs(c.x - 9.5) < 1.5 && std::fabs(c.y - 9.5) < 0.5; });
    sheet.points[9 * 20 + 9] = sheet.points[10 * 20 + 9] = {9, 9.4, 0};
    fill_holes_in_place(sheet.points, sheet.spacing, {}, sheet.surface, {});
    for (const Triangle& t : sheet.surface.triangles)
        EXPECT_GT(length(cross(sheet.points[t[1]] - sheet.points[t[0]],
                               sheet.points[t[2]] - sheet.points[t[0]])),
                  0.0);
}

}  // namespace
}  // namespace pointbake
