// Cleaning as users see it: options, messages, exit codes, report and written rows.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "run_program.h"

namespace pointbake::cli {
namespace {

using Json = nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::Pair;

constexpr int kSurface = 20'000, kOutliers = 3, kPiece = 19;

/// An egg, three points far from it, and a small ball beside it.
std::vector<Vec3d> dirty_points() {
    std::vector<Vec3d> points = egg_points(kSurface);
    for (const double z : {1.0, 1.5, 2.0}) points.push_back({0.1, 0.2, z});
    for (const Vec3d& p : egg_points(kPiece)) points.push_back(p * 0.03 + Vec3d{1.5, 0, 0});
    return points;
}

class Cleaning : public testing::Test {
 protected:
    Cleaning() { folder_.write("in.ply", ascii_ply(dirty_points())); }

    /// Only as far as the points, which is quick; the report goes to stdout.
    ProgramRun run(std::vector<std::string> words) const {
        words.insert(words.begin(), {"in.ply", "-o", "out.ply", "--stop-after", "attributes"});
        words.insert(words.end(), {"--report", "-"});
        return run_program(folder_, words);
    }
    Json counts(const std::vector<std::string>& words) const {
        const ProgramRun done = run(words);
        EXPECT_EQ(done.exit_code, 0) << done.err;
        return Json::parse(done.out)["clean"];
    }

    TemporaryFolder folder_;
};

/// Of a file of --write-points with double coordinates.
constexpr std::size_t kRowBytes = 3 * sizeof(double) + 4 + 2;

/// How often each reason stands in a file of --write-points with double coordinates.
std::map<int, int> reasons(const std::string& ply) {
    std::map<int, int> counts;
    for (std::size_t at = ply.find("end_header\n") + 11; at < ply.size(); at += kRowBytes) {
        const int kept = ply[at + kRowBytes - 2], reason = ply[at + kRowBytes - 1];
        EXPECT_EQ(kept != 0, reason <= 1);
        ++counts[reason];
    }
    return counts;
}

TEST_F(Cleaning, DropsOutliersAndFloatersAndTellsEverywhere) {
    const ProgramRun done = run({"--write-points", "rows.ply"});
    ASSERT_EQ(done.exit_code, 0) << done.err;
    EXPECT_THAT(done.err, HasSubstr("cleaned: 3 outliers, 19 points of 1 floating piece dropped"));
    const Json clean = Json::parse(done.out)["clean"];
    EXPECT_EQ(clean["outliers"], kOutliers);
    EXPECT_EQ(clean["floating_points"], kPiece);
    EXPECT_EQ(clean["floating_pieces"], 1);
    EXPECT_EQ(clean["cropped"], 0);
    EXPECT_EQ(clean["subsampled"], 0);
    EXPECT_THAT(folder_.read("out.ply"), HasSubstr("element vertex 20000\n"));
    const std::string rows = folder_.read("rows.ply");
    EXPECT_THAT(
        rows,
        AllOf(HasSubstr("comment reason 4 outlier"), HasSubstr("comment reason 5 floating"),
              HasSubstr("comment reason 6 cropped"), HasSubstr("comment reason 7 subsampled")));
    EXPECT_THAT(reasons(rows), ElementsAre(Pair(0, kSurface), Pair(4, kOutliers), Pair(5, kPiece)));
}

TEST_F(Cleaning, KeepsThemWhenTold) {
    const Json outliers = counts({"--floaters", "keep"});
    EXPECT_EQ(outliers["outliers"], kOutliers);
    EXPECT_EQ(outliers["floating_points"], 0);
    const ProgramRun done = run({"--floaters", "keep", "--outliers", "keep"});
    EXPECT_THAT(done.err, Not(HasSubstr("cleaned")));
    EXPECT_THAT(folder_.read("out.ply"), HasSubstr("element vertex 20022\n"));
}

TEST_F(Cleaning, CropsAndThins) {
    const ProgramRun done =
        run({"--crop", "-2,-2,-2,0,2,2", "--subsample", "5%", "--write-points", "rows.ply"});
    ASSERT_EQ(done.exit_code, 0) << done.err;
    const Json clean = Json::parse(done.out)["clean"];
    const auto num_right = static_cast<int>(
        std::ranges::count_if(dirty_points(), [](const Vec3d& p) { return p.x > 0.0; }));
    const int num_thinned = clean["subsampled"];
    EXPECT_EQ(clean["cropped"], num_right);
    EXPECT_EQ(clean["outliers"], 0);
    EXPECT_GT(num_thinned, 9000);
    EXPECT_THAT(done.err, HasSubstr(" points outside of --crop, "));
    EXPECT_THAT(done.err, HasSubstr(" points nearer than --subsample dropped"));
    const int num_kept = kSurface + kOutliers + kPiece - num_right - num_thinned;
    EXPECT_THAT(reasons(folder_.read("rows.ply")),
                ElementsAre(Pair(0, num_kept), Pair(6, num_right), Pair(7, num_thinned)));
}

TEST_F(Cleaning, SpacingsInMetresFollowTheScale) {
    EXPECT_EQ(counts({"--subsample", "10cm", "--scale", "0.5"})["subsampled"],
              counts({"--subsample", "0.2"})["subsampled"]);
}

TEST_F(Cleaning, NothingLeftIsExitSixAndNamesTheOption) {
    const ProgramRun done = run({"--crop", "10,10,10,11,11,11"});
    EXPECT_EQ(done.exit_code, 6);
    EXPECT_THAT(done.err, AllOf(HasSubstr("pointbake: error: in.ply: --crop 10,10,10,11,11,11"),
                                HasSubstr("20022 points")));
    EXPECT_THAT(folder_.files(), ElementsAre("in.ply"));
}

TEST_F(Cleaning, WrongValuesAreExitTwo) {
    const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
        {{"--crop", "1,2,3"}, "--crop: '1,2,3' is not a box: expected x0,y0,z0,x1,y1,z1"},
        {{"--crop", "0,0,5,1,1,1"}, "crop is 0,0,5,1,1,1: the lower bounds"},
        {{"--subsample", "0"}, "subsample is 0"},
        {{"--subsample", "-1"}, "is not a length"},
        {{"--outliers", "off"}, "expected drop, keep"},
        {{"--floaters", "no"}, "expected drop, keep"},
    };
    for (const auto& [words, hint] : cases) {
        const ProgramRun done = run(words);
        EXPECT_EQ(done.exit_code, 2) << words[0];
        EXPECT_THAT(done.err, HasSubstr(hint));
    }
}

TEST_F(Cleaning, OptionsHaveAGroupAndCanBeDumped) {
    EXPECT_THAT(run_program(folder_, {"--help"}).out,
                AllOf(HasSubstr("\nCleaning\n"), HasSubstr("--crop BOX"),
                      HasSubstr("--outliers drop|keep"), HasSubstr("--subsample LENGTH")));
    EXPECT_THAT(run_program(folder_, {"simplify", "--help"}).out, Not(HasSubstr("--outliers")));
    const ProgramRun dump =
        run_program(folder_, {"--dump-options", "--crop", "0,0,0,1,2,3.5", "--subsample", "2mm"});
    const Json options = Json::parse(dump.out);
    EXPECT_EQ(options["crop"], "0,0,0,1,2,3.5");
    EXPECT_EQ(options["subsample"], "0.002m");
    EXPECT_EQ(options["outliers"], "drop");
    folder_.write("options.json", dump.out);
    EXPECT_EQ(run_program(folder_, {"--dump-options", "--config", "options.json"}).out, dump.out);
}

TEST_F(Cleaning, PlansTellWhatWouldGo) {
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"info", "in.ply"}, {"in.ply", "out.glb", "--dry-run"}})
        EXPECT_THAT(run_program(folder_, words).out,
                    HasSubstr("drop 3 outliers, 19 points of 1 floating piece"));
}

TEST_F(Cleaning, LeavesPointsOfAGivenSurfaceAlone) {
    folder_.write("faces.ply",
                  "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                  "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                  "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    const ProgramRun faces =
        run_program(folder_, {"faces.ply", "o.glb", "--surface", "given", "--crop", "0,0,0,1,1,1"});
    EXPECT_EQ(faces.exit_code, 2);
    EXPECT_THAT(faces.err, HasSubstr("--surface given"));

    const Json clean = counts({"--mesh", "faces.ply", "--crop", "-9,-9,-9,9,9,1.7"});
    EXPECT_EQ(clean["outliers"], 0);
    EXPECT_EQ(clean["floating_points"], 0);
    EXPECT_EQ(clean["cropped"], 1);
}

/// An egg whose points lie a third of a spacing off it, the one half in, the other out.
std::vector<Vec3d> rough_points() {
    std::vector<Vec3d> points = egg_points(kSurface);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double off = 2.0 * static_cast<double>(i * 7919 % 1000) / 999.0 - 1.0;
        points[i] = points[i] * (1.0 + 0.012 * off);
    }
    return points;
}

TEST_F(Cleaning, MovesNoisyPointsAndTellsByHowMuch) {
    folder_.write("in.ply", ascii_ply(rough_points()));
    const ProgramRun done = run({"--write-points", "rows.ply", "-v"});
    ASSERT_EQ(done.exit_code, 0) << done.err;
    EXPECT_THAT(done.err, HasSubstr("denoise: noise of 0."));
    const Json denoise = Json::parse(done.out)["denoise"];
    EXPECT_EQ(denoise["done"], true);
    EXPECT_GT(denoise["noise_in_spacings"], 0.1);
    EXPECT_LT(denoise["noise_left"], 0.1);
    EXPECT_GT(denoise["shift_rms"], 0.001);
    EXPECT_LT(denoise["shift_max"], 0.1);
    // The rows stand where they were read.
    const std::string rows = folder_.read("rows.ply");
    const std::vector<Vec3d> read = rough_points();
    std::size_t at = rows.find("end_header\n") + 11;
    for (std::size_t i = 0; i < read.size(); ++i, at += kRowBytes) {
        Vec3d written;
        std::memcpy(&written, rows.data() + at, sizeof(written));
        ASSERT_EQ(written, read[i]) << i;
    }
}

TEST_F(Cleaning, LeavesNoiseWithDenoiseOff) {
    folder_.write("in.ply", ascii_ply(rough_points()));
    const Json off = Json::parse(run({"--denoise", "off"}).out)["denoise"];
    EXPECT_EQ(off["done"], false);
    EXPECT_GT(off["noise_in_spacings"], 0.1);
    EXPECT_EQ(run({"--denoise", "maybe"}).exit_code, 2);
}

}  // namespace
}  // namespace pointbake::cli
