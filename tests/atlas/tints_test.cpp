#include "atlas/tints.h"

#include <gtest/gtest.h>

#include <numeric>

namespace pointbake {
namespace {

std::vector<PatchShape> squares(std::span<const Vec3f> colors) {
    std::vector<PatchShape> out(colors.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i].rows.assign(4, {0, 3});
        out[i].color = colors[i];
    }
    return out;
}

std::vector<Index> all(std::size_t n) {
    std::vector<Index> out(n);
    std::iota(out.begin(), out.end(), Index{0});
    return out;
}

// 1000 greys in no order.
std::vector<Vec3f> greys() {
    std::vector<Vec3f> out;
    for (int i = 0; i < 1000; ++i) {
        const float v = static_cast<float>((i * 391) % 1000) / 999.0F;
        out.push_back({v, v, v});
    }
    return out;
}

TEST(Tints, RunThroughTheColours) {
    const std::vector<Vec3f> colors = greys();
    const Tints tints(squares(colors));
    const Tints::Row row = tints.row_of(all(colors.size()));
    for (std::size_t k = 0; k < row.size(); ++k)
        EXPECT_NEAR(row[k].x, (static_cast<double>(k) + 0.5) / static_cast<double>(row.size()),
                    0.01);
}

TEST(Tints, DistanceIsAThirdInTheMean) {
    const std::vector<Vec3f> colors = greys();
    const Tints tints(squares(colors));
    const Tints::Row row = tints.row_of(all(colors.size()));
    double sum = 0.0;
    for (Index i = 0; i < colors.size(); ++i) {
        for (int k = 0; k < 20; ++k) sum += tints.distance(i, row, (k + 0.5) / 20.0);
        EXPECT_LT(tints.distance(i, row, static_cast<double>(colors[i].x)), 0.02);
    }
    EXPECT_NEAR(sum / (20.0 * static_cast<double>(colors.size())), 1.0 / 3.0, 0.01);
}

TEST(Tints, ARowKnowsOnlyItsOwnShapes) {
    const std::vector<Vec3f> colors = greys();
    const Tints tints(squares(colors));
    std::vector<Index> dark;
    for (Index i = 0; i < colors.size(); ++i)
        if (colors[i].x < 0.25F) dark.push_back(i);
    const Tints::Row row = tints.row_of(dark);
    EXPECT_NEAR(row.front().x, 0.0, 0.01);
    EXPECT_NEAR(row.back().x, 0.25, 0.01);
}

TEST(Tints, OneColourIsNowhereWrong) {
    for (const std::size_t count : {1, 5, 50}) {
        const std::vector<Vec3f> colors(count, Vec3f{0.3F, 0.6F, 0.9F});
        const Tints tints(squares(colors));
        EXPECT_TRUE(tints.are_one());
        for (const double x : {0.0, 0.5, 1.0})
            EXPECT_EQ(tints.distance(0, tints.row_of(all(count)), x), 0.0) << count;
    }
}

TEST(Tints, WideShapesBelongWhereTheyLie) {
    // Three of a row: a third each, with no parts that nothing belongs to.
    const std::vector<Vec3f> colors{{0.9F, 0, 0}, {0.3F, 0, 0}, {0.6F, 0, 0}};
    const Tints tints(squares(colors));
    const Tints::Row row = tints.row_of(all(3));
    const auto third = row.size() / 3;
    EXPECT_FLOAT_EQ(row.front().x, 0.3F);
    EXPECT_FLOAT_EQ(row[third - 2].x, 0.3F);
    EXPECT_FLOAT_EQ(row[third + 2].x, 0.6F);
    EXPECT_FLOAT_EQ(row[2 * third - 2].x, 0.6F);
    EXPECT_FLOAT_EQ(row[2 * third + 3].x, 0.9F);
    EXPECT_FLOAT_EQ(row.back().x, 0.9F);
}

TEST(OrderByColor, LikeColoursFollowEachOther) {
    const std::vector<Vec3f> colors = greys();
    const std::vector<Index> place = order_by_color(squares(colors));
    for (std::size_t i = 0; i < colors.size(); ++i)
        EXPECT_NEAR(place[i], 999.0F * colors[i].x, 2.0);
}

}  // namespace
}  // namespace pointbake
