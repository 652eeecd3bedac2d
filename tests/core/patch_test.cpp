#include "pointbake/patch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>

#include "core/hash.h"
#include "pointbake/error.h"

namespace pointbake {
namespace {

using Corners = std::array<Vec2d, 3>;
using Texel = std::pair<int, int>;

bool has(const NeedSet& set, int x, int y) {
    const int j = y - set.offset_y;
    if (j < 0 || j >= set.shape.height()) return false;
    const PatchShape::Span row = set.shape.rows[static_cast<std::size_t>(j)];
    return x - set.offset_x >= row.left && x - set.offset_x <= row.right;
}

// The extent of (corners - axis) along an axis, doubled coordinates: all in integers.
struct Range {
    std::int64_t low = INT64_MAX, high = INT64_MIN;
    void extend(std::int64_t v) {
        low = std::min(low, v);
        high = std::max(high, v);
    }
};

// Separating axes: does the open square of half-size 1 around (x, y) meet the closed triangle?
// Exact for integer corners.
bool square_meets_triangle(const Corners& corners, int x, int y) {
    std::array<std::array<std::int64_t, 2>, 3> p{};
    for (std::size_t k = 0; k < 3; ++k)
        p[k] = {static_cast<std::int64_t>(corners[k].x), static_cast<std::int64_t>(corners[k].y)};
    std::vector<std::array<std::int64_t, 2>> axes{{1, 0}, {0, 1}};
    for (std::size_t k = 0; k < 3; ++k) {
        const auto &a = p[k], &b = p[(k + 1) % 3];
        axes.push_back({b[1] - a[1], a[0] - b[0]});
    }
    for (const auto& n : axes) {
        if (n[0] == 0 && n[1] == 0) continue;
        Range triangle;
        for (const auto& q : p) triangle.extend(n[0] * q[0] + n[1] * q[1]);
        const std::int64_t centre = n[0] * x + n[1] * y;
        const std::int64_t radius = std::abs(n[0]) + std::abs(n[1]);
        if (triangle.low >= centre + radius || triangle.high <= centre - radius) return false;
    }
    return true;
}

TEST(NeedSet, OfMarkedTexelsKnowsTheirGaps) {
    const std::vector<std::uint8_t> marked{0, 0, 0, 0, 0, 0,  //
                                           0, 0, 1, 0, 1, 0,  //
                                           0, 1, 1, 1, 1, 1,  //
                                           0, 0, 1, 0, 0, 1};
    const NeedSet set = need_set(marked, 6);
    EXPECT_EQ(set.offset_x, 1);
    EXPECT_EQ(set.offset_y, 1);
    EXPECT_EQ(set.shape.width(), 5);
    EXPECT_EQ(set.shape.height(), 3);
    EXPECT_EQ(set.shape.num_texels(), 9);
    ASSERT_EQ(set.shape.gaps.size(), 2U);
    EXPECT_EQ(set.shape.gaps[1].row, 2);
    EXPECT_EQ(set.shape.gaps[1].span.left, 2);
    EXPECT_EQ(set.shape.gaps[1].span.right, 3);
}

void expect_exact(const Corners& corners) {
    const NeedSet set = need_set(corners);
    for (int y = set.offset_y - 2; y < set.offset_y + set.shape.height() + 2; ++y)
        for (int x = set.offset_x - 2; x < set.offset_x + set.shape.width() + 2; ++x)
            ASSERT_EQ(has(set, x, y), square_meets_triangle(corners, x, y))
                << "texel " << x << ' ' << y << " of (" << corners[0].x << ' ' << corners[0].y
                << "), (" << corners[1].x << ' ' << corners[1].y << "), (" << corners[2].x << ' '
                << corners[2].y << ")";
}

double random_in(std::uint64_t seed, std::uint64_t i, double low, double high) {
    return low + (high - low) * random_unit(seed, i);
}

TEST(NeedSet, OfAPointOnATexelIsThatTexel) {
    const NeedSet set = need_set({Vec2d{5, -3}, Vec2d{5, -3}, Vec2d{5, -3}});
    EXPECT_EQ(set.shape.num_texels(), 1);
    EXPECT_EQ(set.offset_x, 5);
    EXPECT_EQ(set.offset_y, -3);
}

TEST(NeedSet, OfAPointBetweenTexelsIsTheirSquare) {
    const NeedSet set = need_set({Vec2d{0.5, 0.25}, Vec2d{0.5, 0.25}, Vec2d{0.5, 0.25}});
    EXPECT_EQ(set.shape.num_texels(), 4);
    EXPECT_EQ(set.shape.height(), 2);
    EXPECT_EQ(set.shape.width(), 2);
}

TEST(NeedSet, OfASegmentAlongTexelsIsThoseTexels) {
    EXPECT_EQ(need_set({Vec2d{0, 0}, Vec2d{4, 0}, Vec2d{2, 0}}).shape.num_texels(), 5);
    EXPECT_EQ(need_set({Vec2d{0, 0}, Vec2d{0, 4}, Vec2d{0, 2}}).shape.num_texels(), 5);
}

TEST(NeedSet, OfBaseTwoAndHeightOneHasSixTexels) {
    const NeedSet set = need_set({Vec2d{0, 1}, Vec2d{2, 1}, Vec2d{1, 0}});
    EXPECT_EQ(set.shape.num_texels(), 6);
    EXPECT_EQ(set.shape.height(), 2);
    EXPECT_EQ(set.shape.width(), 3);
}

// The count of texels grows as b h / 2 plus the border; vertices on texels keep the border small.
TEST(NeedSet, OfSmallTrianglesOnTexelsIsSmall) {
    const auto mean = [](double base, double shift) {
        double sum = 0.0;
        constexpr int kRuns = 2000;
        for (std::uint64_t i = 0; i < kRuns; ++i) {
            const double h = std::max(1.0, std::round(base * random_in(1, i, 0.2, 0.87)));
            const Vec2d o{shift * random_unit(2, i), shift * random_unit(3, i)};
            const double apex = base * random_in(4, i, 0.1, 0.9);
            const Corners c{Vec2d{0, 0} + o, Vec2d{base, 0} + o, Vec2d{apex, h} + o};
            sum += static_cast<double>(need_set(c).shape.num_texels());
        }
        return sum / kRuns;
    };
    EXPECT_LT(mean(2, 0.0), 7.0);
    EXPECT_GT(mean(2, 1.0), 10.0);
    EXPECT_LT(mean(6, 0.0), 0.85 * mean(6, 1.0));
}

TEST(NeedSet, IsExactForIntegerCorners) {
    for (std::uint64_t i = 0; i < 1000; ++i) {
        const double size = i % 3 == 0 ? 4.0 : (i % 3 == 1 ? 20.0 : 60.0);
        Corners c;
        for (std::size_t k = 0; k < 3; ++k)
            c[k] = {std::floor(random_in(10 + k, i, -size, size)),
                    std::floor(random_in(20 + k, i, -size, size))};
        expect_exact(c);
        if (HasFatalFailure()) return;
    }
}

TEST(NeedSet, IsExactForNeedles) {
    for (int dx = 0; dx < 40; ++dx)
        for (int dy = 0; dy < 8; ++dy)
            expect_exact({Vec2d{0, 0}, Vec2d{37, 5},
                          Vec2d{static_cast<double>(dx), static_cast<double>(dy)}});
}

TEST(NeedSet, NeverMissesABilinearTap) {
    for (std::uint64_t i = 0; i < 300; ++i) {
        const double size = i % 2 == 0 ? 3.0 : 25.0;
        Corners c;
        for (std::size_t k = 0; k < 3; ++k)
            c[k] = {random_in(30 + k, i, 0, size), random_in(40 + k, i, 0, size)};
        const NeedSet set = need_set(c);
        std::set<Texel> read;
        for (std::uint64_t s = 0; s < 2000; ++s) {
            double u = random_unit(50, i * 2000 + s), v = random_unit(51, i * 2000 + s);
            if (s % 4 == 0) v = 0.0;  // on an edge
            if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
            const Vec2d p = c[s % 3] * (1.0 - u - v) + c[(s + 1) % 3] * u + c[(s + 2) % 3] * v;
            const int x = static_cast<int>(std::floor(p.x)), y = static_cast<int>(std::floor(p.y));
            for (int k = 0; k < 4; ++k) {
                const int tx = x + k % 2, ty = y + k / 2;
                const double weight = (1.0 - std::fabs(p.x - tx)) * (1.0 - std::fabs(p.y - ty));
                if (weight <= 1e-6) continue;
                ASSERT_TRUE(has(set, tx, ty)) << "triangle " << i << ", texel " << tx << ' ' << ty;
                read.insert({tx, ty});
            }
        }
        // and what it holds is read, up to corners that 2000 samples miss
        EXPECT_GE(static_cast<double>(read.size()),
                  0.8 * static_cast<double>(set.shape.num_texels()));
    }
}

TEST(NeedSet, IgnoresRoundingErrorsOfIntegers) {
    const Corners exact{Vec2d{0, 0}, Vec2d{12, 0}, Vec2d{5, 8}};
    const NeedSet wanted = need_set(exact);
    for (std::uint64_t i = 0; i < 100; ++i) {
        Corners c = exact;
        for (std::size_t k = 0; k < 3; ++k)
            c[k] =
                c[k] + Vec2d{random_in(60 + k, i, -1e-9, 1e-9), random_in(70 + k, i, -1e-9, 1e-9)};
        const NeedSet set = need_set(c);
        EXPECT_EQ(set.shape.num_texels(), wanted.shape.num_texels());
        EXPECT_EQ(set.offset_x, 0);
        EXPECT_EQ(set.offset_y, 0);
    }
}

TEST(NeedSet, DoesNotDependOnTheOrderOfCorners) {
    for (std::uint64_t i = 0; i < 200; ++i) {
        Corners c;
        for (std::size_t k = 0; k < 3; ++k)
            c[k] = {random_in(80 + k, i, 0, 9), random_in(90 + k, i, 0, 9)};
        const NeedSet a = need_set(c), b = need_set({c[1], c[2], c[0]}),
                      d = need_set({c[1], c[0], c[2]});
        ASSERT_EQ(a.shape.num_texels(), b.shape.num_texels());
        ASSERT_EQ(a.shape.num_texels(), d.shape.num_texels());
    }
}

TEST(NeedSet, RefusesCornersThatAreNoTexels) {
    EXPECT_THROW(need_set({Vec2d{0, 0}, Vec2d{NAN, 0}, Vec2d{0, 1}}), Error);
    EXPECT_THROW(need_set({Vec2d{0, 0}, Vec2d{1e12, 0}, Vec2d{0, 1}}), Error);
}

}  // namespace
}  // namespace pointbake
