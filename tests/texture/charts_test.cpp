// Charts on surfaces whose shape is known.
#include "texture/charts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "core/adjacency.h"
#include "core/hash.h"
#include "core/union_find.h"
#include "support/shapes.h"
#include "texture/chart_density.h"
#include "texture/flatten.h"

namespace pointbake {
namespace {

Charts charts_of(const Mesh& mesh) {
    return grow_charts(mesh, triangle_neighbors(mesh.triangles), {});
}

double area_of(const std::array<Vec2d, 3>& c) { return 0.5 * cross(c[1] - c[0], c[2] - c[0]); }

// Largest singular value of the map from a triangle to its chart's plane, or one over the smallest.
double stretch_of(const Mesh& mesh, Index t, const std::array<Vec2d, 3>& flat) {
    const Triangle& tri = mesh.triangles[t];
    const Vec3d b = mesh.positions[tri[1]] - mesh.positions[tri[0]],
                c = mesh.positions[tri[2]] - mesh.positions[tri[0]];
    const double l = length(b), h = length(cross(b, c)) / l, foot = dot(b, c) / l;
    const Vec2d x = (flat[1] - flat[0]) / l, y = (flat[2] - flat[0] - x * foot) / h;
    const double det = cross(x, y), sum = dot(x, x) + dot(y, y);
    const double high =
        std::sqrt(0.5 * (sum + std::sqrt(std::max(0.0, sum * sum - 4 * det * det))));
    return std::max(high, high / det);
}

// What every layout must hold.
void expect_good(const Mesh& mesh, const Charts& charts) {
    const auto neighbors = triangle_neighbors(mesh.triangles);
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        ASSERT_LT(charts.of_triangle[t], charts.count);
        EXPECT_GT(area_of(charts.corners[t]), 0.0) << "turned over: " << t;
        EXPECT_LE(stretch_of(mesh, t, charts.corners[t]), kMaxChartStretch + 1e-9);
        for (std::size_t k = 0; k < 3; ++k) {
            const Index next = neighbors[t][k];
            if (next == kInvalidIndex || charts.of_triangle[next] != charts.of_triangle[t])
                continue;
            const Triangle& other = mesh.triangles[next];
            for (std::size_t j = 0; j < 3; ++j)
                if (other[j] == mesh.triangles[t][k]) {
                    EXPECT_EQ(charts.corners[next][j], charts.corners[t][k]) << "torn: " << t;
                }
        }
    }
    // No two triangles of a chart cover the same: neither holds the middle of the other.
    for (Index a = 0; a < mesh.triangles.size(); ++a)
        for (Index b = 0; b < mesh.triangles.size(); ++b) {
            if (a == b || charts.of_triangle[a] != charts.of_triangle[b]) continue;
            const auto& c = charts.corners[a];
            const auto& d = charts.corners[b];
            const Vec2d m = (d[0] + d[1] + d[2]) / 3.0;
            const bool holds = cross(c[1] - c[0], m - c[0]) > 0.0 &&
                               cross(c[2] - c[1], m - c[1]) > 0.0 &&
                               cross(c[0] - c[2], m - c[2]) > 0.0;
            EXPECT_FALSE(holds) << a << " covers " << b;
        }
}

// n x m quads over place(s, t), s and t in [0, 1].
template <class Place>
Mesh sheet(int n, int m, Place&& place) {
    Mesh mesh;
    for (int j = 0; j <= m; ++j)
        for (int i = 0; i <= n; ++i)
            mesh.positions.push_back(place(static_cast<double>(i) / n, static_cast<double>(j) / m));
    for (int j = 0; j < m; ++j)
        for (int i = 0; i < n; ++i) {
            const auto a = static_cast<Index>(j * (n + 1) + i), b = a + 1,
                       c = a + static_cast<Index>(n) + 1, d = c + 1;
            mesh.triangles.push_back({a, b, d});
            mesh.triangles.push_back({a, d, c});
        }
    return mesh;
}

TEST(Charts, AFlatSheetIsOneChartWithoutStretch) {
    const Mesh mesh = sheet(8, 5, [](double s, double t) { return Vec3d{s, t, 0.3 * s}; });
    const Charts charts = charts_of(mesh);
    expect_good(mesh, charts);
    EXPECT_EQ(charts.count, 1U);
    for (Index t = 0; t < mesh.triangles.size(); ++t)
        EXPECT_NEAR(stretch_of(mesh, t, charts.corners[t]), 1.0, 1e-7);
}

TEST(Charts, AHalfCylinderUnrolls) {
    // 110 degrees: a projection would stretch its ends by 1.7.
    const Mesh mesh = sheet(24, 6, [](double s, double t) {
        const double a = (s - 0.5) * 1.92;
        return Vec3d{std::sin(a), 0.5 * t, std::cos(a)};
    });
    const Charts charts = charts_of(mesh);
    expect_good(mesh, charts);
    EXPECT_EQ(charts.count, 1U);
}

TEST(Charts, ASphereTakesAFew) {
    const Mesh mesh = sheet(40, 20, [](double s, double t) {
        const double a = 6.283185307179586 * s, b = 0.05 + 3.04 * t;
        return Vec3d{std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), -std::cos(b)};
    });
    const Charts charts = charts_of(mesh);
    expect_good(mesh, charts);
    EXPECT_LE(charts.count, 12U);
}

TEST(Charts, ASpiralStairIsNotLaidOverItself) {
    // Two turns of a ramp: seen from above the second lies over the first.
    const Mesh mesh = sheet(80, 3, [](double s, double t) {
        const double a = 12.5 * s, r = 0.5 + 0.5 * t;
        return Vec3d{r * std::cos(a), r * std::sin(a), 0.4 * s};
    });
    const Charts charts = charts_of(mesh);
    expect_good(mesh, charts);
    EXPECT_GE(charts.count, 2U);
}

TEST(Charts, ThinLayersAreNotLaidOverEachOther) {
    // A washer of a turn and a fifth: where it overlaps itself it is nearly in one plane.
    const Mesh mesh = sheet(60, 3, [](double s, double t) {
        const double a = 7.5 * s, r = 0.5 + 0.5 * t;
        return Vec3d{r * std::cos(a), r * std::sin(a), 0.01 * s};
    });
    const Charts charts = charts_of(mesh);
    expect_good(mesh, charts);
    EXPECT_GE(charts.count, 2U);
}

TEST(Charts, SoupIsAChartEach) {
    Mesh mesh;
    for (Index i = 0; i < 50; ++i) {
        const double x = i;
        for (const Vec3d p : {Vec3d{x, 0, 0}, Vec3d{x + 0.5, 0, 0}, Vec3d{x, 0.5, 0.1 * x}})
            mesh.positions.push_back(p);
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const Charts charts = charts_of(mesh);
    expect_good(mesh, charts);
    EXPECT_EQ(charts.count, 50U);
}

TEST(Charts, TrianglesWithoutAnAreaAreNoTrouble) {
    Mesh mesh = sheet(4, 4, [](double s, double t) { return Vec3d{s, t, 0.0}; });
    mesh.positions.push_back({7, 7, 7});
    mesh.triangles.push_back({0, 1, 1});
    mesh.triangles.push_back({25, 25, 25});
    const Charts charts = charts_of(mesh);
    for (const Index c : charts.of_triangle) EXPECT_LT(c, charts.count);
}

TEST(Charts, ThreeSheetsOnAnEdgeStayApart) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 1, 0}, {1, 0.5, 0}, {-1, 0.5, 0.1}, {0, 0.5, 1}};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 4, 1}};
    expect_good(mesh, charts_of(mesh));
}

// A flat sheet of 40 x 40 squares of side 0.025 in one chart, and what its triangles want.
struct Wanting {
    Mesh mesh = sheet(40, 40, [](double u, double v) { return Vec3d{u, v, 0.0}; });
    std::vector<std::array<Index, 3>> neighbors = triangle_neighbors(mesh.triangles);
    Charts charts = charts_of(mesh);
    std::vector<double> wanted;

    template <class Density>
    explicit Wanting(Density&& density) {
        for (const Triangle& t : mesh.triangles) {
            const Vec3d m =
                (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3.0;
            wanted.push_back(density(m.x, m.y));
        }
    }
    void split() { split_by_density_in_place(charts, wanted, 4.0, neighbors); }
    double num_texels() const {
        std::vector<double> area(charts.count), border(charts.count), most(charts.count);
        for (Index t = 0; t < wanted.size(); ++t) {
            const Index c = charts.of_triangle[t];
            area[c] += area_of(charts.corners[t]);
            most[c] = std::max(most[c], wanted[t]);
            for (std::size_t k = 0; k < 3; ++k) {
                const Index next = neighbors[t][k];
                if (next == kInvalidIndex || charts.of_triangle[next] != c)
                    border[c] += length(charts.corners[t][(k + 1) % 3] - charts.corners[t][k]);
            }
        }
        double sum = 0.0;
        for (Index c = 0; c < charts.count; ++c)
            sum += chart_texels(area[c], border[c], most[c], 4.0);
        return sum;
    }
};

TEST(ChartDensity, CutsBetweenFlatPaintAndLettering) {
    Wanting w([](double x, double) { return x < 0.25 ? 400.0 : 60.0; });
    ASSERT_EQ(w.charts.count, 1U);
    const double before = w.num_texels();
    w.split();
    EXPECT_EQ(w.charts.count, 2U);
    for (Index t = 0; t < w.wanted.size(); ++t)
        EXPECT_EQ(w.charts.of_triangle[t] == w.charts.of_triangle[0], w.wanted[t] == w.wanted[0]);
    EXPECT_LT(w.num_texels(), 0.35 * before);
}

TEST(ChartDensity, CutsGradualChangesToo) {
    Wanting w([](double x, double) { return 60.0 + 600.0 * x * x; });
    const double before = w.num_texels();
    w.split();
    EXPECT_GE(w.charts.count, 2U);
    EXPECT_LT(w.num_texels(), 0.6 * before);
}

TEST(ChartDensity, TakesItsTimeOnLargeChartsOfManyWishes) {
    // Wishes below what the triangles' own size asks for, at random: merging is free everywhere.
    Mesh mesh = sheet(256, 256, [](double u, double v) { return Vec3d{u, v, 0.0}; });
    Charts charts;
    std::vector<double> wanted;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        std::array<Vec2d, 3> flat;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d p = mesh.positions[mesh.triangles[t][k]];
            flat[k] = {p.x, p.y};
        }
        charts.corners.push_back(flat);
        charts.of_triangle.push_back(0);
        wanted.push_back(100.0 * random_unit(3, t));
    }
    charts.count = 1;
    split_by_density_in_place(charts, wanted, 4.0, triangle_neighbors(mesh.triangles));
    EXPECT_LT(charts.count, 20U);
}

TEST(ChartDensity, AnIslandOfLetteringIsCutOut) {
    Wanting w([](double x, double y) {
        return std::abs(x - 0.5) < 0.15 && std::abs(y - 0.5) < 0.15 ? 400.0 : 60.0;
    });
    w.split();
    EXPECT_EQ(w.charts.count, 2U);
}

TEST(ChartDensity, LeavesWholeWhatCuttingWouldNotSave) {
    // Noise, less than a factor of two, on sheets that need many texels or few; and a step between
    // two parts that are small in texels.
    for (const double scale : {1.0, 0.1}) {
        Wanting w([&](double x, double y) {
            const double noise = random_unit(7, static_cast<std::uint64_t>(1e6 * (x + 50.0 * y)));
            return scale * (200.0 + 60.0 * noise);
        });
        w.split();
        EXPECT_EQ(w.charts.count, 1U);
    }
    Wanting small([](double x, double) { return x < 0.25 ? 20.0 : 3.0; });
    small.split();
    EXPECT_EQ(small.charts.count, 1U);
}

TEST(ChartDensity, PartsAreConnectedAndStayInTheirChart) {
    // A checkerboard of wishes on a sphere of several charts.
    Mesh mesh = shapes::sphere_mesh(24);
    const auto neighbors = triangle_neighbors(mesh.triangles);
    Charts charts = charts_of(mesh);
    const Charts before = charts;
    std::vector<double> wanted;
    for (const Triangle& t : mesh.triangles) {
        const Vec3d m = (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3.0;
        wanted.push_back((m.x > 0.0) != (m.y > 0.3) ? 900.0 : 100.0);
    }
    split_by_density_in_place(charts, wanted, 4.0, neighbors);
    EXPECT_GT(charts.count, before.count);
    expect_good(mesh, charts);
    UnionFind together(mesh.triangles.size());
    std::map<Index, Index> chart_before;
    for (Index t = 0; t < wanted.size(); ++t) {
        for (const Index next : neighbors[t])
            if (next != kInvalidIndex && charts.of_triangle[next] == charts.of_triangle[t])
                together.unite(t, next);
        EXPECT_EQ(chart_before.emplace(charts.of_triangle[t], before.of_triangle[t]).first->second,
                  before.of_triangle[t]);
    }
    std::set<Index> roots;
    for (Index t = 0; t < wanted.size(); ++t) roots.insert(together.find(t));
    EXPECT_EQ(roots.size(), charts.count);
}

TEST(Flatten, GivesUpOnWhatCannotBe) {
    // A tall cone: nothing lays it flat without a cut.
    Mesh mesh;
    mesh.positions.push_back({0, 0, 3});
    FlatCorners corners;
    std::vector<Index> all;
    constexpr Index kSides = 12;
    for (Index i = 0; i < kSides; ++i) {
        const double a = 6.283185307179586 * i / kSides;
        mesh.positions.push_back({std::cos(a), std::sin(a), 0});
    }
    for (Index i = 0; i < kSides; ++i) {
        const Triangle t{0, 1 + i, 1 + (i + 1) % kSides};
        std::array<Vec2d, 3> flat;
        for (std::size_t k = 0; k < 3; ++k)
            flat[k] = {mesh.positions[t[k]].x, mesh.positions[t[k]].y};
        mesh.triangles.push_back(t);
        corners.push_back(flat);
        all.push_back(i);
    }
    EXPECT_FALSE(flatten(mesh, all, corners));
    // Half of it is no trouble.
    EXPECT_TRUE(flatten(mesh, std::span(all).first(kSides / 2),
                        {corners.begin(), corners.begin() + kSides / 2}));
}

}  // namespace
}  // namespace pointbake
