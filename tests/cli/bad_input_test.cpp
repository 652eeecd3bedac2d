// Bad input and bad places for output: a clear message, the documented exit code, little time and
// memory, nothing left behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <limits>

#include "run_program.h"

namespace pointbake::cli {
namespace {

using testing::HasSubstr;

constexpr double kMostSeconds = 2.0;
constexpr long kMostKilobytes = 300'000;

std::string header(std::string_view format, std::string_view count) {
    return "ply\nformat " + std::string(format) + " 1.0\nelement vertex " + std::string(count) +
           "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
}

std::string zeros(std::size_t bytes) { return std::string(bytes, '\0'); }

/// Runs a conversion that must fail: only the input is left.
void expect_refused(std::string_view content, int exit_code, std::string_view what) {
    const TemporaryFolder folder;
    folder.write("in.ply", content);
    const ProgramRun run = run_program(folder, {"in.ply", "out.glb", "--report", "report.json"});
    EXPECT_EQ(run.exit_code, exit_code) << what << ": " << run.err;
    EXPECT_THAT(run.err, HasSubstr("pointbake: error: ")) << what;
    EXPECT_EQ(run.out, "") << what;
    EXPECT_LT(run.seconds, kMostSeconds) << what;
    EXPECT_LT(run.peak_kilobytes, kMostKilobytes) << what;
    EXPECT_THAT(folder.files(), testing::ElementsAre("in.ply")) << what;
}

std::vector<Vec3d> line(std::size_t n) {
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < n; ++i) {
        const double t = static_cast<double>(i);
        points.push_back({t, 2.0 * t, -t});
    }
    return points;
}

TEST(BadInput, FilesThatAreNoCloudsAreUnreadable) {
    expect_refused("", 3, "an empty file");
    expect_refused("hello, this is no point cloud\n1 2 3\n", 3, "text");
    expect_refused("ply\n", 3, "a header that breaks off");
    expect_refused(header("ascii", "3") + "1 2 3\nx y z\n4 5 6\n", 3, "words for numbers");
    expect_refused(header("ascii", "-5"), 3, "a negative count");
}

TEST(BadInput, HeadersThatPromiseTooMuchAreUnreadable) {
    expect_refused(header("binary_little_endian", "1000") + zeros(120), 3, "cut-off binary");
    expect_refused(header("binary_little_endian", "1000") + zeros(12 * 999 + 5), 3,
                   "the last row is cut");
    expect_refused(header("ascii", "1000") + "0 0 0\n1 0 0\n0 1 0\n", 3, "ascii that ends early");
    expect_refused(header("binary_little_endian", "4294967295") + zeros(1200), 3, "2^32 - 1");
    expect_refused(header("ascii", "4294967295") + "0 0 0\n", 3, "2^32 - 1 in ascii");
    expect_refused(header("ascii", "99999999999999999999999") + "0 0 0\n", 3, "more than 2^64");
}

TEST(BadInput, PointsThatMakeNoSurfaceAreUnreadable) {
    expect_refused(ascii_ply(line(1)), 3, "one point");
    expect_refused(ascii_ply(line(2)), 3, "two points");
    expect_refused(ascii_ply(line(3)), 3, "three points on a line");
    expect_refused(ascii_ply(line(500)), 3, "points on a line");
    expect_refused(ascii_ply(std::vector<Vec3d>(100, Vec3d{1.0, 2.0, 3.0})), 3, "equal points");
}

TEST(BadInput, OnePointTellsWhatTookTheOthers) {
    const TemporaryFolder folder;
    const auto told = [&](std::vector<std::string> words) {
        words.insert(words.begin(), {"in.ply", "out.glb"});
        const ProgramRun run = run_program(folder, words);
        EXPECT_EQ(run.exit_code, 3) << run.err;
        return run.err;
    };
    folder.write("in.ply", ascii_ply(std::vector<Vec3d>(100, Vec3d{1.0, 2.0, 3.0})));
    EXPECT_THAT(told({}),
                HasSubstr("in.ply: 1 point left of 100 rows (99 with the coordinates of another)"));
    folder.write("in.ply", ascii_ply(egg_points(90)));
    EXPECT_THAT(told({"--subsample", "1e9"}),
                HasSubstr("1 point left of 90 rows (89 nearer than --subsample)"));
    folder.write("in.ply", ascii_ply(line(2)));
    EXPECT_THAT(told({"--crop", "0,0,-1,0,1,1"}),
                HasSubstr("1 point left of 2 rows (1 outside of --crop)"));
    EXPECT_THAT(told({}), HasSubstr("2 points: a surface needs at least 3"));
}

TEST(BadInput, CoplanarPointsAreNoWatertightSurface) {
    const TemporaryFolder folder;
    std::vector<Vec3d> points;
    for (int i = 0; i < 400; ++i) points.push_back({0.1 * (i % 20), 0.1 * (i / 20), 5.0});
    folder.write("in.ply", ascii_ply(points));
    for (const char* method : {"auto", "implicit"}) {
        const ProgramRun run =
            run_program(folder, {"in.ply", "--method", method, "--surface", "watertight"});
        EXPECT_EQ(run.exit_code, 3) << method;
        EXPECT_THAT(run.err, HasSubstr("the points lie in a plane")) << method;
    }
}

TEST(BadInput, NothingLeftAfterCleaningIsExitSix) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    expect_refused(ascii_ply(std::vector<Vec3d>(50, Vec3d{nan, nan, nan})), 6, "NaN everywhere");
    expect_refused(ascii_ply({}), 6, "no points");
}

TEST(BadInput, FoldersAndMissingFilesAreUnreadable) {
    const TemporaryFolder folder;
    for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
             {".", "out.glb"},
             {"missing.ply", "out.glb"},
             {"info", "missing.ply"},
             {"sample", "missing.obj", "out.ply"},
             {"missing.ply", "--mesh", "missing.obj", "out.glb"}}) {
        const ProgramRun run = run_program(folder, words);
        EXPECT_EQ(run.exit_code, 3) << testing::PrintToString(words) << run.err;
        EXPECT_LT(run.seconds, kMostSeconds);
    }
    EXPECT_TRUE(folder.files().empty());
}

TEST(BadInput, CoplanarPointsConvert) {
    const TemporaryFolder folder;
    std::vector<Vec3d> points;
    for (int i = 0; i < 400; ++i) points.push_back({0.1 * (i % 20), 0.1 * (i / 20), 5.0});
    folder.write("in.ply", ascii_ply(points));
    const ProgramRun run = run_program(folder, {"in.ply"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(folder.files(), testing::ElementsAre("in.glb", "in.ply"));
}

TEST(BadOutput, PlacesThatCannotBeWrittenAreExitFourBeforeTheWork) {
    const TemporaryFolder folder;
    folder.write("in.ply", ascii_ply(egg_points(20'000)));
    std::filesystem::create_directory(folder / "folder.glb");
    for (const std::vector<std::string>& words :
         std::vector<std::vector<std::string>>{{"in.ply", "none/out.glb"},
                                               {"in.ply", "folder.glb"},
                                               {"in.ply", "out.glb", "--report", "none/r.json"},
                                               {"in.ply", "out.glb", "--work-dir", "in.ply/x"}}) {
        const ProgramRun run = run_program(folder, words);
        EXPECT_EQ(run.exit_code, 4) << testing::PrintToString(words) << run.err;
        EXPECT_LT(run.seconds, kMostSeconds);
    }
    EXPECT_THAT(folder.files(), testing::ElementsAre("folder.glb", "in.ply"));
}

TEST(BadOutput, AFolderWithoutPermissionIsExitFour) {
    if (geteuid() == 0) GTEST_SKIP() << "the superuser may write everywhere";
    const TemporaryFolder folder;
    folder.write("in.ply", ascii_ply(egg_points(200)));
    std::filesystem::create_directory(folder / "locked");
    std::filesystem::permissions(folder / "locked", std::filesystem::perms::owner_read);
    EXPECT_EQ(run_program(folder, {"in.ply", "locked/out.glb"}).exit_code, 4);
    std::filesystem::permissions(folder / "locked", std::filesystem::perms::owner_all);
}

TEST(BadOutput, AFullDiskIsExitFourAndTheOldOutputStays) {
    const TemporaryFolder folder;
    folder.write("in.ply", ascii_ply(egg_points(2000)));
    folder.write("out.glb", "the old one");
    // A limit on the size of files fails in the middle of writing, as a full disk does.
    const ProgramRun run = run_program(folder, {"in.ply", "out.glb"}, 8);
    EXPECT_EQ(run.exit_code, 4) << run.err;
    EXPECT_THAT(run.err, HasSubstr("out.glb"));
    EXPECT_THAT(folder.files(), testing::ElementsAre("in.ply", "out.glb"));
    EXPECT_EQ(folder.read("out.glb"), "the old one");
}

}  // namespace
}  // namespace pointbake::cli
