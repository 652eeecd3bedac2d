// What surface comes of which cloud: what --surface auto makes of clouds whose answer a person
// would not doubt, and that the density of the points does not matter.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/hash.h"
#include "pointbake/model.h"
#include "run_program.h"

namespace pointbake::cli {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

fs::path data_folder() {
    const char* elsewhere = std::getenv("POINTBAKE_DATA");
    return elsewhere != nullptr ? fs::path(elsewhere)
                                : fs::path(POINTBAKE_SOURCE) / "../shared/data";
}

/// The report's section on the surface that auto chose.
Json surface_of(const TemporaryFolder& folder, const std::string& cloud) {
    const ProgramRun done = run_program(
        folder, {cloud, "-o", "dense.ply", "--stop-after", "reconstruct", "--report", "-"});
    EXPECT_EQ(done.exit_code, 0) << done.err;
    return done.exit_code == 0 ? Json::parse(done.out)["reconstruct"] : Json{};
}

TEST(Auto, ClosesTheDemoModel) {
    TemporaryFolder folder;
    ASSERT_EQ(run_program(folder, {"demo", "demo.glb", "--points", "40000"}).exit_code, 0);
    const Json surface = surface_of(folder, "demo-points.ply");
    EXPECT_EQ(surface["surface"], "watertight") << surface["reason"];
    EXPECT_EQ(surface["boundary_loops"], 0);
}

TEST(Auto, LeavesAHalfSphereOpen) {
    TemporaryFolder folder;
    std::vector<Vec3d> points;
    for (const Vec3d& p : egg_points(40000))
        if (p.y > 0.0) points.push_back(p);
    folder.write("half.ply", ascii_ply(points));
    const Json surface = surface_of(folder, "half.ply");
    EXPECT_EQ(surface["surface"], "open") << surface["reason"];
    EXPECT_EQ(surface["boundary_loops"], 1);
}

struct RealCase {
    std::string file;  ///< in the data folder: a cloud, or a mesh that is sampled
    std::string expected;
};

class AutoOnRealFiles : public testing::TestWithParam<RealCase> {};

TEST_P(AutoOnRealFiles, ChoosesWhatAPersonWould) {
    const fs::path file = data_folder() / GetParam().file;
    if (!fs::exists(file))
        GTEST_SKIP() << file << " is not there: POINTBAKE_DATA names the folder with it";
    TemporaryFolder folder;
    std::string cloud = file.string();
    if (file.extension() == ".obj") {
        ASSERT_EQ(run_program(folder,
                              {"sample", cloud, "cloud.ply", "--points", "60000", "--mode", "blue"})
                      .exit_code,
                  0);
        cloud = "cloud.ply";
    }
    const Json surface = surface_of(folder, cloud);
    EXPECT_EQ(surface["surface"], GetParam().expected) << surface["reason"];
}

INSTANTIATE_TEST_SUITE_P(Clouds, AutoOnRealFiles,
                         testing::Values(RealCase{"textured/spot.obj", "watertight"},
                                         RealCase{"textured/bob.obj", "watertight"},
                                         RealCase{"scans/igea.ply", "watertight"},
                                         RealCase{"textured/ferry_tile.obj", "open"},
                                         RealCase{"textured/copyroom.obj", "open"},
                                         RealCase{"colored_points/lion_takanawa.ply", "open"},
                                         RealCase{"colored_points/o3d_livingroom_002.ply", "open"},
                                         RealCase{"colored_points/qcompass_outcrop.laz", "open"}),
                         [](const auto& c) { return fs::path(c.param.file).stem().string(); });

// Two clouds of one surface, one with patches a sixteenth as dense as the rest, make the same mesh.
struct TwoDensities {
    TemporaryFolder folder;
    std::vector<Vec3d> even, uneven;

    Json convert(const std::string& name, const std::vector<Vec3d>& points) const {
        folder.write(name + ".ply", ascii_ply(points));
        const ProgramRun done = run_program(folder, {name + ".ply", "-o", name + "-mesh.ply",
                                                     "--stop-after", "simplify", "--report", "-"});
        EXPECT_EQ(done.exit_code, 0) << done.err;
        return done.exit_code == 0 ? Json::parse(done.out) : Json{};
    }

    /// How far the even points lie from a mesh.
    Json distances(const std::string& mesh) const {
        const ProgramRun held =
            run_program(folder, {"even.ply", "-o", "held.ply", "--mesh", mesh, "--keep-mesh",
                                 "--stop-after", "simplify", "--report", "-"});
        EXPECT_EQ(held.exit_code, 0) << held.err;
        return held.exit_code == 0 ? Json::parse(held.out)["simplify"]["point_distances"] : Json{};
    }

    /// The quantile of the distances that must be less than so many bounds of simplification.
    void expect_same_mesh(const char* quantile, double num_bounds) const {
        const Json of_even = convert("even", even), of_uneven = convert("uneven", uneven);
        for (const Json* report : {&of_even, &of_uneven}) {
            EXPECT_EQ((*report)["reconstruct"]["surface"], "watertight");
            EXPECT_EQ((*report)["reconstruct"]["components"], 1);
        }
        const double triangles = of_even["simplify"]["triangles"];
        EXPECT_NEAR(of_uneven["simplify"]["triangles"].get<double>(), triangles, 0.1 * triangles);
        const double farthest = distances("uneven-mesh.ply")[quantile];
        EXPECT_LT(farthest, num_bounds * of_even["simplify"]["bound"].get<double>());
    }
};

// Both sides of a sheet are outside: Tight Cocone encloses nothing of it.
TEST(Watertight, SheetsAreClosedByTheImplicitMethod) {
    TemporaryFolder folder;
    std::vector<Vec3d> points;
    for (std::uint64_t i = 0; i < 6000; ++i) {
        const double x = random_unit(1, 2 * i), y = random_unit(1, 2 * i + 1);
        points.push_back({x, y, 0.02 * x * x});
    }
    folder.write("in.ply", ascii_ply(points));
    const ProgramRun run =
        run_program(folder, {"in.ply", "-o", "out.ply", "--surface", "watertight", "--stop-after",
                             "simplify", "--report", "-"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Json report = Json::parse(run.out);
    EXPECT_EQ(report["reconstruct"]["method"], "implicit") << report["reconstruct"];
    EXPECT_EQ(report["reconstruct"]["boundary_loops"], 0);
    EXPECT_THAT(report["reconstruct"]["reason"].get<std::string>(),
                testing::HasSubstr("would lose"));
    EXPECT_LT(report["simplify"]["points_off_surface"].get<double>(), 60.0);
}

// A ball over a sheet of four times its area: the ball could be closed, the sheet would be lost.
TEST(Watertight, WhatWouldLoseMostIsClosedByTheImplicitMethod) {
    TemporaryFolder folder;
    std::vector<Vec3d> points;
    for (const Vec3d& p : egg_points(2000)) points.push_back(p + Vec3d{0.0, 0.0, 3.0});
    for (int i = -35; i <= 35; ++i)
        for (int j = -35; j <= 35; ++j)
            points.push_back({0.1 * i, 0.1 * j, 0.002 * (i * 0.1) * (i * 0.1)});
    folder.write("in.ply", ascii_ply(points));
    const ProgramRun run =
        run_program(folder, {"in.ply", "-o", "out.ply", "--surface", "watertight", "--stop-after",
                             "reconstruct", "--report", "-"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Json surface = Json::parse(run.out)["reconstruct"];
    EXPECT_EQ(surface["method"], "implicit") << surface["reason"];
    EXPECT_THAT(surface["reason"].get<std::string>(), testing::Not(testing::HasSubstr("100.0 %")));
    EXPECT_EQ(surface["components"], 2);
    EXPECT_EQ(surface["boundary_loops"], 0);
}

TEST(Thin, KeepsToAShareOfTheGeometryBound) {
    TemporaryFolder folder;
    folder.write("in.ply", ascii_ply(egg_points(40000)));
    const auto num_vertices = [&](const char* bound) {
        const ProgramRun run =
            run_program(folder, {"in.ply", "-o", "out.ply", "--geometry-error", bound,
                                 "--stop-after", "reconstruct", "--report", "-"});
        EXPECT_EQ(run.exit_code, 0) << run.err;
        return run.exit_code == 0 ? Json::parse(run.out)["reconstruct"]["vertices"].get<int>() : 0;
    };
    EXPECT_LT(num_vertices("1%"), 36000);
    EXPECT_EQ(num_vertices("0.001%"), 40000);
}

TEST(Density, DoesNotShapeTheMesh) {
    TwoDensities clouds;
    clouds.even = egg_points(40000);
    for (const int n : {80000, 5000})
        for (const Vec3d& p : egg_points(n)) {
            const bool is_dense =
                std::sin(6 * p.x) * std::sin(5 * p.y + 1) * std::sin(7 * p.z) > 0.0;
            if (is_dense == (n == 80000)) clouds.uneven.push_back(p);
        }
    // The bound holds at a mesh's own points; between sparse ones it is not known.
    clouds.expect_same_mesh("max", 1.5);
    clouds.expect_same_mesh("p99", 1.0);
}

// Dense where the paint is dark: edges of the paint are jumps in density, in the middle of faces as
// on creases. Creases themselves are no nearer than the sparse points are to each other.
TEST(Density, OfThePaintDoesNotShapeTheDemoModel) {
    const PointCloud cloud = demo_cloud(800'000);
    TwoDensities clouds;
    std::uint64_t num_dark = 0;
    const auto is_dark = [&](std::size_t i) {
        const Rgb16 c = cloud.colors[i];
        return 0.3 * c.r + 0.6 * c.g + 0.1 * c.b < 32768.0;
    };
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        if (is_dark(i) || hash64(i) % 16 == 0) clouds.uneven.push_back(cloud.positions[i]);
        num_dark += is_dark(i) ? 1 : 0;
    }
    ASSERT_GT(num_dark, cloud.size() / 10);
    for (std::size_t i = 0; i < cloud.size(); ++i)
        if (hash64(i) % cloud.size() < clouds.uneven.size())
            clouds.even.push_back(cloud.positions[i]);
    clouds.expect_same_mesh("p99", 1.0);
}

}  // namespace
}  // namespace pointbake::cli
