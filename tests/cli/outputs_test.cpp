// What a conversion writes beside a GLB with PNG: other images, no images, other files.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/hash.h"
#include "run_program.h"
#include "support/check_glb.h"

namespace pointbake::cli {
namespace {

using Json = nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// The points of an ASCII PLY with colours that change from point to point.
std::string speckled(const std::vector<Vec3d>& points) {
    std::string text = fmt::format(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\n"
        "property double y\nproperty double z\nproperty uchar red\n"
        "property uchar green\nproperty uchar blue\nend_header\n",
        points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3d p = points[i];
        text += fmt::format("{} {} {} {} {} {}\n", p.x, p.y, p.z, hash64(1, i) % 256,
                            hash64(2, i) % 256, hash64(3, i) % 256);
    }
    return text;
}

class Outputs : public testing::Test {
 protected:
    Outputs() { folder_.write("in.ply", speckled(egg_points(2000))); }

    ProgramRun run(std::vector<std::string> words) const {
        words.insert(words.begin(), "in.ply");
        return run_program(folder_, words);
    }
    ProgramRun run_well(const std::vector<std::string>& words) const {
        ProgramRun done = run(words);
        EXPECT_EQ(done.exit_code, 0) << testing::PrintToString(words) << "\n" << done.err;
        return done;
    }
    Json report() const { return Json::parse(folder_.read("report.json")); }

    TemporaryFolder folder_;
};

const std::vector<std::string> kSmall = {"--triangles", "300", "--report", "report.json"};
std::vector<std::string> with(std::vector<std::string> words) {
    words.insert(words.end(), kSmall.begin(), kSmall.end());
    return words;
}

TEST_F(Outputs, WhatAFormatLosesCountsAgainstTheBound) {
    const std::vector<std::string> common = {"a.glb", "--texture-error", "6"};
    const auto measured = [&](std::vector<std::string> more) {
        more.insert(more.begin(), common.begin(), common.end());
        const ProgramRun done = run_well(with(more));
        return std::pair(report()["texture"], done.err);
    };
    const auto png = measured({}).first;
    const auto [rough, warning] = measured({"--texture-format", "jpeg", "--texture-quality", "20"});
    const auto exact = measured({"--texture-format", "webp", "--texture-quality", "100"}).first;
    EXPECT_EQ(exact["error_to_splats"], png["error_to_splats"]);
    EXPECT_EQ(png["capped_triangles"]["by_format"], 0);
    EXPECT_GT(rough["capped_triangles"]["by_format"], 50);
    EXPECT_FALSE(rough["bound_met"].get<bool>());
    EXPECT_GT(rough["error_to_splats"]["rms"], 2 * png["error_to_splats"]["rms"].get<double>());
    EXPECT_GT(rough["error_to_points"]["rms"], png["error_to_points"]["rms"]);
    EXPECT_THAT(warning, HasSubstr("--texture-quality"));
}

TEST_F(Outputs, CodedPagesAreTheSameForAnyNumberOfThreads) {
    for (const char* format : {"jpeg", "webp"}) {
        run_well(with({"a.glb", "--texture-format", format, "--threads", "1"}));
        run_well(with({"b.glb", "--texture-format", format, "--threads", "3"}));
        EXPECT_EQ(folder_.read("a.glb"), folder_.read("b.glb")) << format;
    }
}

TEST_F(Outputs, ReadsItsOwnWebp) {
    run_well(with({"a.glb", "--texture-format", "webp", "--texels", "65536"}));
    const ProgramRun done = run_program(folder_, {"render", "a.glb", "a.png", "--width", "40"});
    EXPECT_EQ(done.exit_code, 0) << done.err;
    EXPECT_THAT(done.err, Not(HasSubstr("plain")));
}

TEST_F(Outputs, NormalMapsStayPng) {
    folder_.write("in.ply", "");
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 2000\nproperty double x\n"
        "property double y\nproperty double z\nend_header\n";
    for (const Vec3d& p : egg_points(2000)) text += fmt::format("{} {} {}\n", p.x, p.y, p.z);
    folder_.write("in.ply", text);
    const ProgramRun done = run_well(with({"a.glb", "--texture-format", "jpeg"}));
    EXPECT_THAT(done.err, HasSubstr("normal maps stay PNG"));
    EXPECT_THAT(folder_.read("a.glb"), HasSubstr("image/png"));
    // Nor is there a colour for vertices.
    const ProgramRun bare = run_well(with({"b.glb", "--texels", "0"}));
    EXPECT_THAT(bare.err, HasSubstr("the mesh has none"));
    EXPECT_THAT(folder_.read("b.glb"),
                testing::AllOf(Not(HasSubstr("COLOR_0")), HasSubstr("NORMAL"),
                               Not(HasSubstr("KHR_materials_unlit"))));
}

TEST_F(Outputs, WithoutTexelsVerticesHaveColors) {
    const ProgramRun done = run_well(with({"a.glb", "--texels", "0"}));
    EXPECT_THAT(done.err, HasSubstr("colours of vertices, no texture"));
    const GlbContents file = check_glb(folder_ / "a.glb");
    EXPECT_THAT(file.problems, testing::IsEmpty());
    EXPECT_TRUE(file.images.empty());
    ASSERT_EQ(file.primitives.size(), 1U);
    EXPECT_EQ(file.primitives[0].colors.size(), file.primitives[0].positions.size());
    EXPECT_TRUE(file.primitives[0].uvs.empty());
    EXPECT_GT(report()["texture"]["error_to_points"]["rms"], 1.0);

    run_well(with({"a.obj", "--texels", "0"}));
    run_well(with({"b.ply", "--texels", "0"}));
    EXPECT_THAT(folder_.files(), Not(testing::Contains(HasSubstr(".png"))));
    EXPECT_THAT(folder_.read("a.obj"), testing::ContainsRegex("\nv( [-0-9.e]+){6}\n"));
    EXPECT_THAT(folder_.read("b.ply"), HasSubstr("red\n"));
    for (const char* option : {"--paper", "--texture-error=3"}) {
        const ProgramRun refused = run({"c.glb", "--texels", "0", option});
        EXPECT_EQ(refused.exit_code, 2) << option;
        EXPECT_THAT(refused.err, HasSubstr("--texels 0"));
    }
}

TEST_F(Outputs, StlIsGeometryAloneAndTakesNoTimeForTextures) {
    const ProgramRun done = run_well(with({"a.stl"}));
    EXPECT_EQ(report()["last_stage"], "simplify");
    EXPECT_THAT(folder_.files(), ElementsAre("a.stl", "in.ply", "report.json"));
    EXPECT_EQ(folder_.read("a.stl").size(),
              84 + 50 * report()["simplify"]["triangles"].get<std::size_t>());
}

TEST_F(Outputs, UsdzAndWebpAreRefusedBeforeTheWork) {
    const ProgramRun done = run({"a.usdz", "--texture-format", "webp"});
    EXPECT_EQ(done.exit_code, 2);
    EXPECT_THAT(done.err, HasSubstr("PNG and JPEG"));
    run_well(with({"a.usdz", "--texture-format", "jpeg"}));
    EXPECT_THAT(folder_.files(), testing::Contains("a.usdz"));
}

TEST_F(Outputs, TheCleanedCloudHasOnlyWhatIsKept) {
    std::vector<Vec3d> points = egg_points(2000);
    points.push_back({0.0, 0.0, 5.0});  // an outlier
    folder_.write("in.ply", speckled(points));
    run_well(with({"a.glb", "--write-cloud", "cloud.ply"}));
    const std::string cloud = folder_.read("cloud.ply");
    EXPECT_EQ(report()["clean"]["outliers"], 1);
    EXPECT_THAT(cloud, testing::AllOf(HasSubstr("element vertex 2000\n"), HasSubstr("nx\n"),
                                      HasSubstr("red\n")));
    const ProgramRun again = run_program(folder_, {"info", "cloud.ply", "--json"});
    EXPECT_EQ(Json::parse(again.out)["points"], 2000);
}

TEST_F(Outputs, CompressionMakesAGlbSmallerAndIsNamedWhenItIsRead) {
    run_well(with({"a.glb", "--texels", "4096"}));
    for (const char* how : {"meshopt", "draco"}) {
        run_well(with({"b.glb", "--texels", "4096", "--compress", how}));
        EXPECT_LT(folder_.read("b.glb").size(), folder_.read("a.glb").size()) << how;
        const ProgramRun read = run_program(folder_, {"render", "b.glb", "b.png"});
        EXPECT_EQ(read.exit_code, 3);
        EXPECT_THAT(read.err, HasSubstr(how)) << "the extension's name";
    }
}

}  // namespace
}  // namespace pointbake::cli
