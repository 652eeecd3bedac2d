#include "io/order.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/color.h"
#include "core/hash.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

PointCloud random_rows(std::size_t n, double scale = 1.0, Vec3d shift = {}) {
    PointCloud rows;
    for (std::size_t i = 0; i < n; ++i) {
        // coarse coordinates: some rows coincide
        const auto at = [&](std::uint64_t axis) {
            return std::floor(random_unit(axis, i) * 16.0) / 16.0 * scale;
        };
        rows.positions.push_back(shift + Vec3d{at(1), at(2), at(3)});
        const auto code = [&](std::uint64_t k) {
            return static_cast<std::uint16_t>(random_unit(k, i) * 65535.0);
        };
        rows.colors.push_back({code(4), code(5), code(6)});
        const Vec3d n3{random_unit(7, i) - 0.5, random_unit(8, i) - 0.5, random_unit(9, i) - 0.5};
        rows.normals.push_back(vec_cast<float>(normalized(n3)));
        rows.radii.push_back(static_cast<float>(random_unit(10, i)));
    }
    Channel channel;
    channel.name = "v";
    channel.data = rows.radii;
    rows.channels.push_back(channel);
    return rows;
}

PointCloud permuted(const PointCloud& rows, const std::vector<std::size_t>& order) {
    PointCloud out = rows;
    for (std::size_t i = 0; i < order.size(); ++i) {
        out.positions[i] = rows.positions[order[i]];
        out.colors[i] = rows.colors[order[i]];
        out.normals[i] = rows.normals[order[i]];
        out.radii[i] = rows.radii[order[i]];
        out.channels[0].data[i] = rows.channels[0].data[order[i]];
    }
    return out;
}

TEST(Order, DoesNotDependOnTheOrderOfRows) {
    const PointCloud rows = random_rows(5000);
    const PointCloud a = order_cloud(rows, {}).cloud;
    EXPECT_LT(a.size(), 4096U);  // there are 16^3 places
    EXPECT_GT(a.merged.size(), 900U);
    std::vector<std::size_t> order(rows.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::uint64_t seed = 20; seed < 23; ++seed) {
        std::sort(order.begin(), order.end(),
                  [&](std::size_t i, std::size_t j) { return hash64(seed, i) < hash64(seed, j); });
        const PointCloud b = order_cloud(permuted(rows, order), {}).cloud;
        EXPECT_EQ(a.positions, b.positions);
        EXPECT_EQ(a.colors, b.colors);
        EXPECT_EQ(a.normals, b.normals);
        EXPECT_EQ(a.radii, b.radii);
        EXPECT_EQ(a.channels[0].data, b.channels[0].data);
    }
}

TEST(Order, MergesEqualPointsIntoTheLowestRow) {
    PointCloud rows;
    rows.positions = {{1, 2, 3}, {0.0, 0, 0}, {1, 2, 3}, {-0.0, 0, -0.0}, {1, 2, 3}};
    rows.colors = {rgb16_from_8bit(0, 10, 0),
                   {},
                   rgb16_from_8bit(255, 10, 0),
                   {},
                   rgb16_from_8bit(255, 10, 0)};
    rows.radii = {1, 5, 2, 7, 6};
    Channel kind, value;
    kind.kind = ChannelKind::kCategory;
    kind.data = {3, 0, 4, 0, 4};
    value.data = {1, 0, std::nanf(""), 0, 3};
    rows.channels = {kind, value};
    const OrderedCloud ordered = order_cloud(rows, {});
    const PointCloud& cloud = ordered.cloud;
    ASSERT_EQ(cloud.size(), 2U);
    EXPECT_EQ(cloud.rows, (std::vector<std::uint64_t>{1, 0}));
    using Pairs = std::vector<std::pair<std::uint64_t, std::uint64_t>>;
    EXPECT_EQ(cloud.merged, (Pairs{{2, 0}, {3, 1}, {4, 0}}));
    EXPECT_EQ(ordered.point_of_row, (std::vector<Index>{1, 0, 1, 0, 1}));
    // two thirds of full red in linear light
    EXPECT_NEAR(cloud.colors[1].r, 65535.0 * linear_to_srgb_exact(2.0 / 3.0), 1.0);
    EXPECT_EQ(cloud.colors[1].g, 2570);
    EXPECT_FLOAT_EQ(cloud.radii[1], 3.0F);
    EXPECT_EQ(cloud.channels[0].data[1], 3.0F) << "categories are not averaged";
    EXPECT_EQ(cloud.channels[1].data[1], 2.0F) << "NaN does not count";
    EXPECT_FALSE(std::signbit(cloud.positions[0].x));
}

TEST(Order, FollowsTheMortonCurve) {
    EXPECT_GT(morton_code({-0.5, 0, 0}, 1.0), morton_code({0.5, 0, 0}, 1.0));
    EXPECT_EQ(morton_code({0, 2097152.0 + 5, 0}, 1.0), morton_code({0, 5, 0}, 1.0));
    EXPECT_EQ(morton_code({1, 0, 0}, 1.0) ^ morton_code({0, 0, 0}, 1.0), 4U);
    EXPECT_EQ(morton_code({0, 1, 0}, 1.0) ^ morton_code({0, 0, 0}, 1.0), 2U);
    EXPECT_EQ(morton_code({0, 0, 1}, 1.0) ^ morton_code({0, 0, 0}, 1.0), 1U);
    EXPECT_EQ(morton_code({0, 2, 0}, 1.0) ^ morton_code({0, 0, 0}, 1.0), 16U);
    const PointCloud cloud = order_cloud(random_rows(3000), {}).cloud;
    Box box;
    for (const Vec3d& p : cloud.positions) box.extend(p);
    for (std::size_t i = 1; i < cloud.size(); ++i)
        EXPECT_LE(morton_code(cloud.positions[i - 1], morton_cell(box)),
                  morton_code(cloud.positions[i], morton_cell(box)));
}

TEST(Order, CellsArePowersOfTwoThatSpanTheExtent) {
    for (double extent : {1e-300, 1e-3, 1.0, 1.5, 4096.0, 1e9, 1e300}) {
        Box box;
        box.extend({-extent / 3, 0, 0});
        box.extend({extent * 2 / 3, 1e-310, 0});
        const double cell = morton_cell(box);
        int exponent = 0;
        EXPECT_EQ(std::frexp(cell, &exponent), 0.5);
        EXPECT_LE(extent / cell, 2097152.0 - 2.0);
        if (extent > 1e-290) {
            EXPECT_GT(extent / cell, 2097152.0 / 2 - 2.0) << extent;
        }
    }
}

TEST(Order, SubsetsOfTheSameExtentKeepTheirOrder) {
    const PointCloud all = order_cloud(random_rows(4000), {}).cloud;
    PointCloud half;
    std::vector<Vec3d> expected;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (i % 2 == 0 || all.positions[i].x == 0.0 || all.positions[i].x == 0.9375) {
            expected.push_back(all.positions[i]);
            half.positions.insert(half.positions.begin(), all.positions[i]);
        }
    EXPECT_EQ(order_cloud(half, {}).cloud.positions, expected);
}

TEST(Order, NeighboursStayCloseFarFromTheOrigin) {
    for (const Vec3d shift : {Vec3d{}, Vec3d{665187.5, 5648349.75, -0.5}}) {
        const PointCloud cloud = order_cloud(random_rows(6000, 14.0, shift), {}).cloud;
        double sum = 0.0;
        for (std::size_t i = 1; i < cloud.size(); ++i)
            sum += length(cloud.positions[i] - cloud.positions[i - 1]);
        // Spacing is 14 / 16; random order would give about 9.
        EXPECT_LT(sum / static_cast<double>(cloud.size() - 1), 2.2);
    }
}

TEST(Order, DegenerateSets) {
    PointCloud none;
    EXPECT_EQ(order_cloud(none, {}).cloud.size(), 0U);
    PointCloud equal;
    equal.positions.assign(1000, Vec3d{1e300, -1e300, 7});
    const PointCloud one = order_cloud(equal, {}).cloud;
    EXPECT_EQ(one.size(), 1U);
    EXPECT_EQ(one.merged.size(), 999U);
    EXPECT_EQ(one.num_rows, 1000U);
    PointCloud bad;
    bad.positions = {{NAN, 0, 0}, {0, HUGE_VAL, 0}, {0, 0, -HUGE_VAL}};
    const OrderedCloud dropped = order_cloud(bad, {});
    EXPECT_EQ(dropped.cloud.size(), 0U);
    EXPECT_EQ(dropped.cloud.dropped.size(), 3U);
    EXPECT_EQ(dropped.point_of_row[1], kInvalidIndex);
    PointCloud huge;
    huge.positions = {{1.7e308, 0, 0}, {-1.7e308, 0, 0}, {0, 1e-308, 0}, {0, 5e-324, 0}};
    EXPECT_EQ(order_cloud(huge, {}).cloud.size(), 4U);
    PointCloud line;
    for (int i = 0; i < 100; ++i) line.positions.push_back({i * 0.01, 0, 0});
    EXPECT_EQ(order_cloud(line, {}).cloud.positions, line.positions);
}

TEST(Order, SameForOneAndSevenThreads) {
    const PointCloud rows = random_rows(20000);
    Context one, seven;
    one.threads = 1;
    seven.threads = 7;
    const PointCloud a = order_cloud(rows, one).cloud;
    const PointCloud b = order_cloud(rows, seven).cloud;
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.colors, b.colors);
    EXPECT_EQ(a.rows, b.rows);
    EXPECT_EQ(a.merged, b.merged);
}

}  // namespace
}  // namespace pointbake::test
