// What surface comes of which cloud: what --surface auto makes of clouds whose answer a person
// would not doubt, and that the density of the points does not matter.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/hash.h"
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
                                         RealCase{"colored_points/o3d_livingroom_002.ply", "open"}),
                         [](const auto& c) { return fs::path(c.param.file).stem().string(); });

/// Patches of full density among others with a sixteenth of it, as paint might have them.
std::vector<Vec3d> uneven(const std::vector<Vec3d>& points) {
    std::vector<Vec3d> some;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3d p = points[i];
        const bool is_dense = std::sin(6 * p.x) * std::sin(5 * p.y + 1) * std::sin(7 * p.z) > 0.0;
        if (is_dense || hash64(i) % 16 == 0) some.push_back(p);
    }
    return some;
}

TEST(Density, DoesNotShapeTheMesh) {
    TemporaryFolder folder;
    folder.write("even.ply", ascii_ply(egg_points(40000)));
    folder.write("uneven.ply", ascii_ply(uneven(egg_points(80000))));
    const auto mesh_of = [&](const std::string& name) {
        const ProgramRun done = run_program(folder, {name + ".ply", "-o", name + "-mesh.ply",
                                                     "--stop-after", "simplify", "--report", "-"});
        EXPECT_EQ(done.exit_code, 0) << done.err;
        return Json::parse(done.out);
    };
    const Json even = mesh_of("even"), other = mesh_of("uneven");
    EXPECT_EQ(other["reconstruct"]["surface"], "watertight");
    const double triangles = even["simplify"]["triangles"];
    EXPECT_NEAR(other["simplify"]["triangles"].get<double>(), triangles, 0.1 * triangles);
    // The even points lie within both bounds of the mesh of the others.
    const ProgramRun held =
        run_program(folder, {"even.ply", "-o", "held.ply", "--mesh", "uneven-mesh.ply",
                             "--keep-mesh", "--stop-after", "simplify", "--report", "-"});
    ASSERT_EQ(held.exit_code, 0) << held.err;
    const double farthest = Json::parse(held.out)["simplify"]["points_to_mesh"]["max"];
    EXPECT_LT(farthest, 2.0 * even["simplify"]["bound"].get<double>());
}

}  // namespace
}  // namespace pointbake::cli
