// Borders of a fine sheet: which notches are filled, which teeth go.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "reconstruct/borders.h"

namespace pointbake {
namespace {

constexpr Index kSide = 20;  // cells
constexpr double kStep = 0.1;
constexpr double kSpacing = 0.05;

Vec3d place(Index i, Index j) { return {kStep * i, kStep * j, 0.0}; }
Index vertex(Index i, Index j) { return j * (kSide + 1) + i; }

/// A square of cells with two triangles each, and points twice as dense under it.
struct Sheet {
    std::vector<Vec3d> vertices, others;
    std::vector<Triangle> triangles;
    std::size_t num_lone_corners = 2;

    Sheet() {
        for (Index j = 0; j <= kSide; ++j)
            for (Index i = 0; i <= kSide; ++i) vertices.push_back(place(i, j));
        for (Index j = 0; j < kSide; ++j) {
            for (Index i = 0; i < kSide; ++i) {
                const Index a = vertex(i, j), b = vertex(i + 1, j), c = vertex(i + 1, j + 1),
                            d = vertex(i, j + 1);
                triangles.push_back({a, b, c});
                triangles.push_back({a, c, d});
            }
        }
        for (int j = -20; j <= 60; ++j)
            for (int i = -20; i <= 60; ++i)
                others.push_back({kSpacing * i + 0.001, kSpacing * j + 0.001, 0.0});
    }

    void drop_vertex(Index v) {
        std::erase_if(triangles,
                      [&](const Triangle& t) { return t[0] == v || t[1] == v || t[2] == v; });
    }

    /// Triangles that trimming adds, less those that it takes away but at the two corners that are
    /// a triangle alone.
    int gain() const {
        std::vector<Vec3d> points = vertices;
        points.insert(points.end(), others.begin(), others.end());
        std::vector<Index> ids(vertices.size());
        std::iota(ids.begin(), ids.end(), Index{0});
        IndexedSurface surface{ids, triangles};
        trim_borders_in_place(vertices, ids, Reach(points), surface, {});
        return static_cast<int>(surface.triangles.size() + num_lone_corners) -
               static_cast<int>(triangles.size());
    }
};

/// Its lower side lacks a vertex.
Sheet notched() {
    Sheet sheet;
    sheet.drop_vertex(vertex(10, 0));
    return sheet;
}

/// A triangle stands out from its lower side.
Sheet toothed(double height) {
    Sheet sheet;
    sheet.vertices.push_back({kStep * 10.5, -height, 0.0});
    const auto apex = static_cast<Index>(sheet.vertices.size() - 1);
    sheet.triangles.push_back({vertex(10, 0), apex, vertex(11, 0)});
    return sheet;
}

TEST(TrimBorders, LeavesStraightBordersAlone) { EXPECT_EQ(Sheet().gain(), 0); }

TEST(TrimBorders, FillsNotchesDeeperThanASpacing) { EXPECT_EQ(notched().gain(), 2); }

TEST(TrimBorders, LeavesShallowNotches) {
    Sheet sheet = notched();
    sheet.others.clear();  // the sheet's own vertices are twice as far apart
    sheet.num_lone_corners = 0;
    EXPECT_EQ(sheet.gain(), 0);
}

TEST(TrimBorders, LeavesNotchesThatAreBent) {
    // Folded at the notch: one of the two triangles over it lies across.
    const auto gain_of = [](double angle) {
        Sheet sheet = notched();
        const auto fold = [&](Vec3d& p) {
            const double beyond = std::max(0.0, p.x - 1.0);
            p += Vec3d{(std::cos(angle) - 1.0) * beyond, 0.0, std::sin(angle) * beyond};
        };
        std::ranges::for_each(sheet.vertices, fold);
        std::ranges::for_each(sheet.others, fold);
        return sheet.gain();
    };
    EXPECT_EQ(gain_of(0.5), 2);
    EXPECT_EQ(gain_of(2.1), 1);
}

TEST(TrimBorders, TakesTeethHigherThanASpacing) {
    EXPECT_EQ(toothed(1.4 * kSpacing).gain(), -1);
    EXPECT_EQ(toothed(0.9 * kSpacing).gain(), 0);
}

TEST(TrimBorders, DoesNotEatStripsUp) {
    // One triangle wide all along: each end may recede by six.
    Sheet strip;
    strip.vertices.clear();
    strip.triangles.clear();
    strip.num_lone_corners = 0;
    constexpr Index kLength = 40;
    for (Index i = 0; i < kLength + 2; ++i)
        strip.vertices.push_back({0.05 * i, i % 2 ? 0.4 : 0.0, 0.0});
    for (Index i = 0; i < kLength; ++i)
        strip.triangles.push_back(i % 2 ? Triangle{i, i + 1, i + 2} : Triangle{i, i + 2, i + 1});
    EXPECT_EQ(strip.gain(), -12);
}

}  // namespace
}  // namespace pointbake
