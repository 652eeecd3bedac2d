// Ctrl-C: a clean end within two seconds.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <thread>

#include "run_program.h"

namespace pointbake::cli {
namespace {

using testing::HasSubstr;

double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// Waits until the program tells of a stage; false after a minute or at its end.
bool reaches(const RunningProgram& program, const std::string& stage) {
    const double deadline = now() + 60.0;
    while (program.err_so_far().find("\"" + stage + "\"") == std::string::npos) {
        if (now() > deadline) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return true;
}

class Interruption : public testing::TestWithParam<const char*> {};

TEST_P(Interruption, EndsTheStageWithinTwoSecondsAndLeavesNothing) {
    const TemporaryFolder folder;
    folder.write("in.ply", ascii_ply(egg_points(60'000)));
    // Four million texels: texture, too, lasts longer than it takes to stop it on a busy machine.
    RunningProgram program(folder,
                           {"in.ply", "out.glb", "--progress", "json", "--texels", "4000000"});
    ASSERT_TRUE(reaches(program, GetParam())) << program.err_so_far();
    const double start = now();
    program.send(SIGINT);
    const ProgramRun run = program.wait();
    EXPECT_LT(now() - start, 2.0);
    EXPECT_EQ(run.exit_code, 130) << run.err;
    EXPECT_THAT(run.err, HasSubstr("pointbake: error: "));
    EXPECT_THAT(folder.files(), testing::ElementsAre("in.ply"));
}

INSTANTIATE_TEST_SUITE_P(EachStage, Interruption,
                         testing::Values("attributes", "reconstruct", "simplify", "texture"));

TEST(Signals, TerminationIsCancellingToo) {
    const TemporaryFolder folder;
    folder.write("in.ply", ascii_ply(egg_points(30'000)));
    RunningProgram program(folder, {"in.ply", "out.glb", "--progress", "json"});
    ASSERT_TRUE(reaches(program, "attributes"));
    program.send(SIGTERM);
    EXPECT_EQ(program.wait().exit_code, 130);
    EXPECT_THAT(folder.files(), testing::ElementsAre("in.ply"));
}

}  // namespace
}  // namespace pointbake::cli
