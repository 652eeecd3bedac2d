// Open surfaces as users see them: holes, and which way they face.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "run_program.h"

namespace pointbake::cli {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;
using testing::Not;

/// An egg up to this height, with normals of these signs along its points.
template <class Sign>
std::string bowl(Sign&& sign, double height = 0.3) {
    std::string rows;
    int count = 0;
    for (const Vec3d& p : egg_points(3000)) {
        if (p.z > height) continue;
        const Vec3d n = normalized(p) * static_cast<double>(sign(count++));
        rows += fmt::format("{} {} {} {} {} {}\n", p.x, p.y, p.z, n.x, n.y, n.z);
    }
    return fmt::format(
               "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
               "property double z\nproperty float nx\nproperty float ny\nproperty float "
               "nz\nend_header\n",
               count) +
           rows;
}

class OpenSurface : public testing::Test {
 protected:
    ProgramRun run(std::vector<std::string> words) const {
        words.insert(words.begin(), {"reconstruct", "in.ply", "out.ply", "--surface", "open"});
        words.insert(words.end(), {"--report", "-"});
        return run_program(folder_, words);
    }
    Json told(const std::vector<std::string>& words) const {
        const ProgramRun done = run(words);
        EXPECT_EQ(done.exit_code, 0) << done.err;
        return Json::parse(done.out)["reconstruct"];
    }

    TemporaryFolder folder_;
};

TEST_F(OpenSurface, FacesTheNormalsOfTheFile) {
    folder_.write("in.ply", bowl([](int) { return 1; }));
    const ProgramRun out = run({});
    ASSERT_EQ(out.exit_code, 0) << out.err;
    EXPECT_THAT(out.err, Not(HasSubstr("contradict")));
    EXPECT_EQ(Json::parse(out.out)["reconstruct"]["turned_pieces"], 0);
    folder_.write("in.ply", bowl([](int) { return -1; }));
    EXPECT_EQ(told({})["turned_pieces"], 1);
}

TEST_F(OpenSurface, WarnsOfNormalsThatContradictEachOther) {
    folder_.write("in.ply", bowl([](int i) { return i % 2 == 0 ? 1 : -1; }));
    const ProgramRun done = run({});
    ASSERT_EQ(done.exit_code, 0) << done.err;
    EXPECT_THAT(done.err, HasSubstr("points contradict each other: estimated anew"));
    const Json json = Json::parse(done.out);
    EXPECT_EQ(json["reconstruct"]["turned_pieces"], 0);
    EXPECT_THAT(json["warnings"].dump(), HasSubstr("contradict"));
}

TEST_F(OpenSurface, FillsHolesOfTheSizeThatIsGiven) {
    folder_.write("in.ply", bowl([](int) { return 1; }, 0.5));
    EXPECT_EQ(told({})["holes_filled"], 0);
    EXPECT_EQ(told({"--fill-holes", "0"})["holes_filled"], 0);
    EXPECT_EQ(told({"--fill-holes", "0.9"})["holes_filled"], 0);  // 1.1 across
    const Json filled = told({"--fill-holes", "1300mm"});
    EXPECT_EQ(filled["holes_filled"], 1);
    EXPECT_EQ(filled["boundary_loops"], 0);
    EXPECT_THAT(run({"--fill-holes", "1300mm"}).err, HasSubstr("; 1 hole filled\n"));
    for (const char* wrong : {"-1", "wide"}) EXPECT_EQ(run({"--fill-holes", wrong}).exit_code, 2);
}

}  // namespace
}  // namespace pointbake::cli
