// Cropping, thinning, and what happens to the arrays and rows of a cloud that loses points.
#include "pointbake/clean.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "core/select_points.h"
#include "pointbake/error.h"
#include "support/shapes.h"

namespace pointbake {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::set<std::tuple<double, double, double>> places(const PointCloud& cloud) {
    std::set<std::tuple<double, double, double>> places;
    for (const Vec3d& p : cloud.positions) places.emplace(p.x, p.y, p.z);
    return places;
}

template <class Body>
std::string error_of(ErrorCode code, Body&& body) {
    try {
        body();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), code) << error.what();
        return error.what();
    }
    ADD_FAILURE() << "no error";
    return {};
}

TEST(SelectPoints, FiltersEveryArrayAndRecordsRows) {
    PointCloud cloud;
    cloud.num_rows = 9;
    cloud.dropped = {{4, {}, DropReason::kNonFinite}};
    for (int i = 0; i < 4; ++i) {
        const auto f = static_cast<float>(i);
        cloud.positions.push_back({1.0 * i, 0, 0});
        cloud.colors.push_back({static_cast<std::uint16_t>(i), 0, 0});
        cloud.normals.push_back({f, 0, 0});
        cloud.radii.push_back(f);
        cloud.areas.push_back(f);
        cloud.axes.push_back({{f, 0, 0}, {}});
        cloud.sensors.push_back({f, 0, 0});
        cloud.weights.push_back(f);
        cloud.rows.push_back(static_cast<std::uint64_t>(8 - 2 * i));
    }
    cloud.channels = {{"pair", "", ChannelKind::kVector, 2, {0, 10, 1, 11, 2, 12, 3, 13}}};
    cloud.rows[2] = 3;
    using enum DropReason;
    const PointCloud out =
        select_points(cloud, std::vector<DropReason>{kOutlier, kKept, kKept, kFloating});
    ASSERT_EQ(out.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
        const auto f = static_cast<float>(i + 1);
        EXPECT_EQ(out.positions[i].x, f);
        EXPECT_EQ(out.colors[i].r, i + 1);
        EXPECT_EQ(out.normals[i].x, f);
        EXPECT_EQ(out.radii[i], f);
        EXPECT_EQ(out.areas[i], f);
        EXPECT_EQ(out.axes[i].u.x, f);
        EXPECT_EQ(out.sensors[i].x, f);
        EXPECT_EQ(out.weights[i], f);
    }
    EXPECT_THAT(out.rows, ElementsAre(6, 3));
    EXPECT_THAT(out.channels[0].data, ElementsAre(1, 11, 2, 12));
    EXPECT_EQ(out.num_rows, 9U);
    ASSERT_EQ(out.dropped.size(), 3U);
    EXPECT_EQ(out.dropped[0].row, 2U);
    EXPECT_EQ(out.dropped[0].reason, kFloating);
    EXPECT_EQ(out.dropped[0].position.x, 3.0);
    EXPECT_EQ(out.dropped[1].reason, kNonFinite);
    EXPECT_EQ(out.dropped[2].row, 8U);
    EXPECT_EQ(out.dropped[2].reason, kOutlier);
}

TEST(SelectPoints, NumbersPointsWithoutRows) {
    PointCloud cloud;
    cloud.positions = {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
    const PointCloud out = select_points(
        cloud, std::vector<DropReason>{DropReason::kCropped, DropReason::kKept, DropReason::kKept});
    EXPECT_THAT(out.rows, ElementsAre(1, 2));
    EXPECT_EQ(out.dropped[0].row, 0U);
}

TEST(Crop, KeepsTheInsideAndTheSides) {
    PointCloud cloud;
    cloud.positions = {{0, 0, 0},     {1, 2, 3},        {0.5, 1, 1},
                       {1.001, 1, 1}, {0.5, -0.001, 1}, {0.5, 1, 3.001}};
    const CleanResult result = clean(cloud, {.crop = Box{{0, 0, 0}, {1, 2, 3}}});
    EXPECT_THAT(result.cloud.rows, ElementsAre(0, 1, 2));
    EXPECT_EQ(result.report.num_cropped, 3U);
    EXPECT_EQ(result.report.num_dropped(), 3U);
    for (const DroppedPoint& point : result.cloud.dropped)
        EXPECT_EQ(point.reason, DropReason::kCropped);
}

TEST(Crop, LeavingNothingIsAnErrorThatNamesTheBox) {
    const std::string what = error_of(ErrorCode::kEmpty, [] {
        clean(shapes::sphere_cloud(200), {.crop = Box{{5, 5, 5}, {6, 6, 6.5}}});
    });
    EXPECT_THAT(what, HasSubstr("--crop 5,5,5,6,6,6.5"));
    EXPECT_THAT(what, HasSubstr("200 points"));
}

TEST(CleanOptions, RefusesWhatCannotBe) {
    const PointCloud cloud = shapes::sphere_cloud(10);
    EXPECT_THAT(error_of(ErrorCode::kInvalidOption,
                         [&] { clean(cloud, {.crop = Box{{0, 3, 0}, {1, 2, 1}}}); }),
                HasSubstr("crop is 0,3,0,1,2,1"));
    EXPECT_THAT(
        error_of(ErrorCode::kInvalidOption, [&] { clean(cloud, {.subsample = units(0.0)}); }),
        HasSubstr("subsample is 0"));
}

TEST(CleanOptions, BoxesAreSixNumbers) {
    const Box box = parse_box("-1,2.5,0,1e3,4,5");
    EXPECT_EQ(box.low, (Vec3d{-1, 2.5, 0}));
    EXPECT_EQ(box.high, (Vec3d{1000, 4, 5}));
    EXPECT_EQ(to_string(box), "-1,2.5,0,1000,4,5");
    for (const char* text :
         {"", "1,2,3", "1,2,3,4,5,6,7", "1,2,3,4,5,x", "1 2 3 4 5 6", "0,0,0,1,1,inf"})
        EXPECT_THAT(error_of(ErrorCode::kInvalidOption, [&] { parse_box(text); }),
                    HasSubstr("x0,y0,z0,x1,y1,z1"))
            << text;
}

/// Every kept pair is apart, and every dropped point has a kept one near.
void expect_disks(const PointCloud& cloud, double spacing) {
    const auto is_near = [&](Vec3d p) {
        return std::ranges::count_if(cloud.positions,
                                     [&](Vec3d q) { return length(q - p) < spacing; });
    };
    for (const Vec3d& p : cloud.positions) EXPECT_EQ(is_near(p), 1);
    for (const DroppedPoint& point : cloud.dropped) {
        EXPECT_EQ(point.reason, DropReason::kSubsampled);
        EXPECT_GE(is_near(point.position), 1);
    }
}

TEST(Subsample, LeavesDisks) {
    for (const double offset : {0.0, -1234.5}) {
        PointCloud cloud = shapes::sphere_cloud(4000, 0.02, 1.0, {offset, 0.1, offset});
        const CleanResult result = clean(cloud, {.subsample = units(0.15)});
        EXPECT_EQ(result.cloud.size() + result.report.num_subsampled, 4000U);
        EXPECT_EQ(result.cloud.dropped.size(), result.report.num_dropped());
        expect_disks(result.cloud, 0.15);
    }
}

TEST(Subsample, KeepsPointsExactlyASpacingApart) {
    const PointCloud cloud = shapes::plane_cloud(9, 9, 0.25);
    EXPECT_EQ(clean(cloud, {.subsample = units(0.25)}).report.num_subsampled, 0U);
    EXPECT_GT(clean(cloud, {.subsample = units(0.2501)}).report.num_subsampled, 20U);
}

TEST(Subsample, TakesPercentOfTheDiagonal) {
    const PointCloud cloud = shapes::plane_cloud(41, 31, 0.1);  // 4 x 3
    EXPECT_EQ(places(clean(cloud, {.subsample = fraction(0.06)}).cloud),
              places(clean(cloud, {.subsample = units(0.3)}).cloud));
}

TEST(Subsample, DependsOnCoordinatesAlone) {
    const PointCloud cloud = shapes::sphere_cloud(3000, 0.01);
    PointCloud reversed = cloud;
    std::ranges::reverse(reversed.positions);
    const CleanOptions options{.subsample = units(0.1)};
    const auto kept = places(clean(cloud, options, {.threads = 1}).cloud);
    EXPECT_EQ(places(clean(reversed, options, {.threads = 4}).cloud), kept);
    EXPECT_LT(kept.size(), 1500U);
}

TEST(Subsample, SpacingsOfAnySizeLeaveAtLeastOne) {
    const PointCloud cloud = shapes::sphere_cloud(300);
    EXPECT_EQ(clean(cloud, {.subsample = units(1e300)}).cloud.size(), 1U);
    EXPECT_EQ(clean(cloud, {.subsample = units(1e-300)}).cloud.size(), 300U);
}

TEST(Clean, TakesAnythingWithoutPointsToSpare) {
    for (const std::uint64_t n : {0U, 1U, 2U, 3U, 17U, 99U, 100U, 101U}) {
        const CleanResult result = clean(shapes::sphere_cloud(n), {.subsample = units(1e-6)});
        EXPECT_EQ(result.cloud.size(), n);
    }
    PointCloud line;
    for (int i = 0; i < 500; ++i) line.positions.push_back({0.1 * i, 0, 0});
    EXPECT_EQ(clean(line).report.num_dropped(), 0U);
}

TEST(Clean, RefusesCoordinatesThatNumbersCannotBear) {
    const auto scaled = [](double by) {
        PointCloud cloud = shapes::sphere_cloud(3000);
        for (Vec3d& p : cloud.positions) p = p * by;
        return cloud;
    };
    for (const double fine : {1e-11, 1.0, 1e14}) EXPECT_NO_THROW(clean(scaled(fine)));
    for (const double bad : {1e-40, 1e16, 1e155, 1e200}) EXPECT_THROW(clean(scaled(bad)), Error);
    PointCloud one_off = shapes::sphere_cloud(3000);
    shapes::add_point(one_off, {1e155, 0, 0}, {1, 0, 0});
    EXPECT_THROW(clean(one_off), Error);
    EXPECT_NO_THROW(clean(one_off, {.crop = Box{{-2, -2, -2}, {2, 2, 2}}}));
}

TEST(Clean, DegenerateCloudsStayWhole) {
    PointCloud line, pair;
    for (int i = 0; i < 500; ++i) shapes::add_point(line, {1.0 * i, 0, 0}, {0, 1, 0});
    for (int i = 0; i < 500; ++i) shapes::add_point(pair, {1e-9 * (i % 2), 0, 0}, {0, 1, 0});
    EXPECT_EQ(clean(line).report.num_dropped(), 0U);
    EXPECT_EQ(clean(pair).report.num_dropped(), 0U);
}

TEST(Clean, StopsWhenTold) {
    std::stop_source stop;
    stop.request_stop();
    const Context context{.stop = stop.get_token()};
    error_of(ErrorCode::kCancelled, [&] { clean(shapes::sphere_cloud(500), {}, context); });
    error_of(ErrorCode::kCancelled,
             [&] { clean(shapes::sphere_cloud(50), {.subsample = units(0.1)}, context); });
}

}  // namespace
}  // namespace pointbake
