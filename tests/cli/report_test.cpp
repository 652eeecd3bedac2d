#include "pointbake/report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "pointbake/error.h"

namespace pointbake {
namespace {

using Json = nlohmann::json;

RunReport example() {
    RunReport report;
    report.input = "scan.ply";
    report.load.num_rows = 12;
    report.load.num_non_finite = 2;
    report.convert.clean = {.num_cropped = 1,
                            .num_outliers = 2,
                            .num_floating = 30,
                            .num_floating_pieces = 4,
                            .num_subsampled = 5};
    report.convert.simplify.bound = HUGE_VAL;
    report.convert.simplify.bound_met = false;
    report.convert.texture.capped.by_budget = 3;
    report.convert.texture.capped.by_spacing = 4;
    report.convert.atlas.pages = {{1024, 512}};
    report.convert.times = {{Stage::kLoad, 0.5, 1000}};
    report.convert.warnings = {"no colours"};
    report.options = R"({"triangles": 5})";
    return report;
}

TEST(Report, HoldsWhatTheStagesTold) {
    const Json json = Json::parse(report_json(example()));
    EXPECT_EQ(json["input"]["rows"], 12);
    EXPECT_EQ(json["input"]["defects"]["non_finite"], 2);
    EXPECT_EQ(json["clean"], Json::parse(R"({"outliers": 2, "floating_points": 30,
        "floating_pieces": 4, "cropped": 1, "subsampled": 5})"));
    EXPECT_FALSE(json["simplify"]["bound_met"]);
    EXPECT_TRUE(json["simplify"]["bound"].is_null());
    EXPECT_EQ(json["texture"]["capped_triangles"]["total"], 7);
    EXPECT_EQ(json["texture"]["capped_triangles"]["by_budget"], 3);
    EXPECT_EQ(json["atlas"]["pages"], Json::parse("[[1024, 512]]"));
    EXPECT_EQ(json["options"]["triangles"], 5);
    EXPECT_EQ(json["warnings"][0], "no colours");
    EXPECT_EQ(json["version"], version());
}

TEST(Report, DiffersBetweenRunsInItsTimingsAlone) {
    RunReport a = example(), b = example();
    b.seconds = 3.0;
    b.threads = 7;
    b.peak_bytes = 99;
    b.convert.times[0].seconds = 0.7;
    b.convert.times[0].peak_bytes = 5;
    Json first = Json::parse(report_json(a)), second = Json::parse(report_json(b));
    EXPECT_NE(first["timings"], second["timings"]);
    first.erase("timings");
    second.erase("timings");
    EXPECT_EQ(first, second);
}

TEST(Report, LeavesOutStagesThatWereNotReached) {
    RunReport report = example();
    report.last_stage = Stage::kReconstruct;
    const Json json = Json::parse(report_json(report));
    EXPECT_TRUE(json.contains("reconstruct"));
    EXPECT_FALSE(json.contains("simplify"));
    EXPECT_FALSE(json.contains("texture"));
}

TEST(Report, StaysJsonForNamesThatAreNotUtf8) {
    RunReport report = example();
    report.input = "scan\xff.ply";
    EXPECT_TRUE(Json::parse(report_json(report), nullptr, false).is_object());
}

TEST(Report, CountsDistancesAndPointsOfKeptPointsOnly) {
    SimplifyResult light;
    light.mesh.triangles.resize(2);
    light.point_triangles = {0, 0, 1, kInvalidIndex, 0};
    light.point_distances = {0.1F, 0.2F, 0.3F, 9.0F, 0.4F};
    RunReport report;
    add_distributions(report, light);
    EXPECT_NEAR(report.point_distances.max, 0.4, 1e-6);
    EXPECT_NEAR(report.point_distances.min, 0.1, 1e-6);
    EXPECT_EQ(report.points_per_triangle.min, 1.0);
    EXPECT_EQ(report.points_per_triangle.max, 3.0);
}

TEST(Quantiles, AreOrderStatisticsOfTheFiniteValues) {
    std::vector<double> values = {NAN, HUGE_VAL};
    for (int i = 100; i >= 0; --i) values.push_back(i);
    const Quantiles q = quantiles(values);
    EXPECT_EQ(q.min, 0.0);
    EXPECT_EQ(q.p05, 5.0);
    EXPECT_EQ(q.median, 50.0);
    EXPECT_EQ(q.p99, 99.0);
    EXPECT_EQ(q.max, 100.0);
    EXPECT_EQ(quantiles({}).max, 0.0);
}

PointCloud grid(int side, double spacing) {
    PointCloud cloud;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            cloud.positions.push_back({x * spacing, y * spacing, 7.0});
            cloud.colors.push_back({0, 257, 25700});
            cloud.normals.push_back(x == 0 ? Vec3f{} : Vec3f{0.0F, 0.0F, 1.0F});
        }
    cloud.channels.push_back(
        {"intensity", "", ChannelKind::kScalar, 1, std::vector<float>(cloud.size(), 3.0F)});
    return cloud;
}

TEST(Summary, MeasuresSpacingExtentAndRanges) {
    const CloudSummary summary = summarize(grid(10, 0.25));
    EXPECT_DOUBLE_EQ(summary.spacing.median, 0.25);
    EXPECT_DOUBLE_EQ(summary.spacing.max, 0.25);
    EXPECT_EQ(summary.box.extent(), (Vec3d{2.25, 2.25, 0.0}));
    ASSERT_EQ(summary.attributes.size(), 3U);
    EXPECT_EQ(summary.attributes[0].name, "colors");
    EXPECT_DOUBLE_EQ(summary.attributes[0].high, 100.0);
    EXPECT_EQ(summary.attributes[1].num_known, 90U);
    EXPECT_EQ(summary.attributes[2].name, "intensity");
    EXPECT_DOUBLE_EQ(summary.attributes[2].low, 3.0);
}

TEST(Summary, IsTheSameForAnyNumberOfThreads) {
    const PointCloud cloud = grid(100, 0.1);
    Context one, seven;
    one.threads = 1;
    seven.threads = 7;
    EXPECT_EQ(info_json("f", {}, summarize(cloud, one), 0),
              info_json("f", {}, summarize(cloud, seven), 0));
}

TEST(Summary, OfFewPointsIsFinite) {
    for (std::size_t n : {0U, 1U, 2U}) {
        PointCloud cloud;
        cloud.positions.resize(n);
        const Json json = Json::parse(info_json("f", {}, summarize(cloud), 0));
        EXPECT_EQ(json["spacing"]["max"], 0.0) << n;
        EXPECT_EQ(json["diagonal"], 0.0) << n;
    }
}

TEST(Summary, StopsWhenTold) {
    std::stop_source source;
    source.request_stop();
    Context context;
    context.stop = source.get_token();
    EXPECT_THROW(summarize(grid(10, 1.0), context), Error);
}

}  // namespace
}  // namespace pointbake
