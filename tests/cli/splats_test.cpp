// Gaussian splats, from file to file.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "io/image_io.h"
#include "run_program.h"
#include "support/shapes.h"

namespace pointbake::cli {
namespace {

using testing::HasSubstr;

template <class T>
std::string raw(T value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
}

/// A ball as .splat: y down, as such files have it, red above and green below.
std::string splat_ball(std::uint64_t n) {
    std::string out;
    for (std::uint64_t i = 0; i < n; ++i) {
        const Vec3d p = shapes::fibonacci_direction(i, n);
        for (std::size_t k = 0; k < 3; ++k) out += raw(static_cast<float>(p[k]));
        for (std::size_t k = 0; k < 3; ++k) out += raw(0.06F);
        out += p.y < 0.0 ? std::string("\xff\x00\x00\xe6", 4) : std::string("\x00\xff\x00\xe6", 4);
        out += std::string("\xff\x80\x80\x80", 4);
    }
    return out;
}

class Splats : public testing::Test {
 protected:
    Splats() { folder_.write("ball.splat", splat_ball(2000)); }
    ProgramRun run(const std::vector<std::string>& words) const {
        return run_program(folder_, words);
    }
    TemporaryFolder folder_;
};

TEST_F(Splats, BecomeAWatertightSurfaceAroundThem) {
    const ProgramRun done = run({"ball.splat", "ball.glb", "--report", "ball.json"});
    ASSERT_EQ(done.exit_code, 0) << done.err;
    EXPECT_THAT(done.err, HasSubstr("surface watertight by opacity: around Gaussian splats"));
    EXPECT_THAT(done.err, HasSubstr("2,000 splats -> "));
    const auto report = nlohmann::json::parse(folder_.read("ball.json"));
    EXPECT_EQ(report["reconstruct"]["components"], 1);
    EXPECT_EQ(report["reconstruct"]["boundary_loops"], 0);
    EXPECT_GT(report["reconstruct"]["splat_points"], 2000);
}

TEST_F(Splats, AreJoinedAsPointsWhereThatIsAskedFor) {
    for (const std::vector<std::string>& asked : {std::vector<std::string>{"--surface", "open"},
                                                  {"--method", "implicit"},
                                                  {"--denoise", "on"}}) {
        const ProgramRun done = run({"ball.splat", "ball.glb", asked[0], asked[1]});
        EXPECT_EQ(done.exit_code, 0) << done.err;
        EXPECT_THAT(done.err, testing::Not(HasSubstr("by opacity")));
        EXPECT_THAT(done.err, HasSubstr("points -> "));
    }
}

TEST_F(Splats, OtherPointsHaveNoOpacity) {
    folder_.write("in.xyz", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n");
    const ProgramRun done = run({"in.xyz", "out.glb", "--method", "opacity"});
    EXPECT_EQ(done.exit_code, 2);
    EXPECT_THAT(done.err, HasSubstr("method 'opacity' is for Gaussian splats"));
    EXPECT_EQ(run({"ball.splat", "out.glb", "--method", "opacity", "--surface", "open"}).exit_code,
              2);
}

TEST_F(Splats, ADryRunTellsWhatBecomesOfThem) {
    EXPECT_THAT(run({"ball.splat", "--dry-run"}).err + run({"ball.splat", "--dry-run"}).out,
                HasSubstr("watertight by opacity, around splats"));
}

TEST_F(Splats, AxesOfFilesWithoutTransformAreNotSaidToBeOverruled) {
    EXPECT_THAT(run({"ball.splat", "a.glb"}).err, HasSubstr("(--up overrules)"));
    EXPECT_THAT(run({"ball.splat", "a.obj"}).err, testing::Not(HasSubstr("overrules")));
}

TEST_F(Splats, AreToldOfRowByRow) {
    // One of them twice: the second is merged.
    folder_.write("twice.splat", splat_ball(2000) + splat_ball(2000).substr(0, 32));
    const ProgramRun done = run({"twice.splat", "out.glb", "--write-points", "rows.ply"});
    ASSERT_EQ(done.exit_code, 0) << done.err;
    EXPECT_THAT(folder_.read("rows.ply"), HasSubstr("element vertex 2001"));
}

TEST_F(Splats, OptionsOfOtherMethodsAreRefused) {
    for (const std::vector<std::string>& asked :
         {std::vector<std::string>{"--thin", "off"}, {"--fill-holes", "1"}, {"--denoise", "on"}}) {
        const ProgramRun done =
            run({"ball.splat", "ball.glb", "--method", "opacity", asked[0], asked[1]});
        EXPECT_EQ(done.exit_code, 2);
        EXPECT_THAT(done.err, HasSubstr(asked[0]));
    }
}

TEST_F(Splats, SurfelsWithConfidenceAreNone) {
    std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 2000\nproperty float x\nproperty float y\nproperty "
        "float z\nproperty float ux\nproperty float uy\nproperty float uz\nproperty float vx\n"
        "property float vy\nproperty float vz\nproperty float weight\nend_header\n";
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const Vec3d p = shapes::fibonacci_direction(i, 2000);
        ply += fmt::format("{} {} {} {} {} {} {} {} {} 0.9\n", p.x, p.y, p.z, 0.06 * p.z, 0.0,
                           -0.06 * p.x, 0.0, 0.06 * p.z, -0.06 * p.y);
    }
    folder_.write("surfels.ply", ply);
    const ProgramRun done = run({"surfels.ply", "out.glb"});
    ASSERT_EQ(done.exit_code, 0) << done.err;
    EXPECT_THAT(done.err, testing::Not(HasSubstr("by opacity")));
}

TEST_F(Splats, AreExpectedToNeedMoreMemory) {
    const ProgramRun done = run({"ball.splat", "out.glb", "--max-memory", "150M"});
    EXPECT_EQ(done.exit_code, 5);
    EXPECT_THAT(done.err, HasSubstr("2,000 splats are expected to need up to 212 MB"));
    EXPECT_EQ(run({"ball.splat", "out.glb", "--max-memory", "150M", "--surface", "open"}).exit_code,
              0);
}

TEST_F(Splats, StandUprightBesideTheirModel) {
    ASSERT_EQ(run({"ball.splat", "ball.glb"}).exit_code, 0);
    const ProgramRun done = run({"render", "ball.splat", "ball.glb", "both.png", "--direction", "z",
                                 "--width", "90", "--height", "90"});
    ASSERT_EQ(done.exit_code, 0) << done.err;
    const std::string file = folder_.read("both.png");
    std::vector<std::byte> bytes(file.size());
    std::memcpy(bytes.data(), file.data(), file.size());
    const Image image = decode_image(bytes, "both.png");
    ASSERT_EQ(image.width, 180);
    for (const int x : {45, 135})
        for (const bool is_above : {true, false}) {
            const std::size_t at = 3 * image.texel(x, is_above ? 35 : 55);
            EXPECT_EQ(image.pixels[at] > 200, is_above);
            EXPECT_EQ(image.pixels[at + 1] > 200, !is_above);
        }
}

}  // namespace
}  // namespace pointbake::cli
