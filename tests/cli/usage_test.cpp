// How the program is talked to: help, versions, wrong words.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "run_program.h"

namespace pointbake::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Usage, HelpAndVersionGoToStdoutForEveryCommand) {
    const TemporaryFolder folder;
    for (const char* command :
         {"convert", "info", "reconstruct", "simplify", "texture", "render", "sample", "demo"}) {
        const ProgramRun help = run_program(folder, {command, "--help"});
        EXPECT_EQ(help.exit_code, 0) << command;
        EXPECT_THAT(help.out, HasSubstr("--threads")) << command;
        EXPECT_EQ(help.err, "") << command;
    }
    const ProgramRun version = run_program(folder, {"--version"});
    EXPECT_EQ(version.exit_code, 0);
    EXPECT_THAT(version.out, testing::StartsWith("pointbake "));
    EXPECT_TRUE(folder.files().empty());
}

TEST(Usage, WrongWordsAreExitTwoWithAHint) {
    const TemporaryFolder folder;
    folder.write("in.ply", ascii_ply(egg_points(50)));
    const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
        {{}, "missing INPUT"},
        {{"in.ply", "--trangles", "5"}, "--triangles"},
        {{"in.ply", "--triangles", "many"}, "'many'"},
        {{"in.ply", "--texture-quality", "80"}, "PNG loses nothing"},
        {{"in.ply", "--triangles"}, "--triangles needs a value"},
        {{"in.ply", "--texture-error", "-3"}, "texture-error is -3"},
        {{"in.ply", "o.glb", "--mesh", "in.ply", "--keep-mesh", "--triangles", "5"}, "--triangles"},
        {{"in.ply", "--surface", "closed"}, "watertight"},
        {{"in.ply", "--surface", "open", "--method", "tight-cocone"}, "implicit makes both"},
        {{"in.ply", "out.fbx"}, ".glb"},
        {{"in.ply", "in.ply"}, "is an input"},
        {{"in.ply", "-o", "in.ply"}, "is an input"},
        {{"in.ply", "-o", "./in.ply"}, "is an input"},
        {{"in.ply", "a.glb", "--report", "a.html"}, ".json"},
        {{"in.ply", "a.ply", "--write-points", "a.ply"}, "named twice"},
        {{"in.ply", "a.glb", "--scale", "0"}, "--scale"},
        {{"in.ply", "--stop-after", "simplify"}, "--work-dir"},
        {{"-q", "info", "in.ply"}, "comes first"},
        {{"texture", "in.ply"}, "CLOUD"},
        {{"in.ply", "out.glb", "--keep-uvs"}, "--mesh"},
        {{"info", "in.ply", "out.ply"}, "too many"},
        {{"render"}, "missing FILE"},
        {{"render", "in.ply", "-o", "picture.jpg"}, ".png"},
        {{"render", "in.ply", "picture.jpg"}, ".png"},
        {{"in.ply", "--page-size", "10"}, "page-size is 10"},
        {{"in.ply", "--texels", "100"}, "buys no page"},
        {{"in.ply", "--geometry-error", "0"}, "geometry-error is 0"},
        {{"in.ply", "a.glb", "--debug-maps", "a.glb"}, "named twice"},
        {{"render", "in.ply", "--direction", "1,2"}, "three numbers"},
        {{"render", "in.ply", "--direction", "0,1,0", "--up", "y"}, "no such view"},
        {{"render", "in.ply", "--direction", "0,0,0"}, "no such view"},
    };
    const std::string input = folder.read("in.ply");
    for (const auto& [words, hint] : cases) {
        const ProgramRun run = run_program(folder, words);
        EXPECT_EQ(run.exit_code, 2) << testing::PrintToString(words) << run.err;
        EXPECT_THAT(run.err, AllOf(HasSubstr("pointbake: error: "), HasSubstr(hint)))
            << testing::PrintToString(words);
        EXPECT_EQ(run.out, "");
    }
    EXPECT_THAT(folder.files(), testing::ElementsAre("in.ply"));
    EXPECT_EQ(folder.read("in.ply"), input);
}

TEST(Usage, MethodsThatTheProgramIsBuiltWithoutAreExitTwoAndTheOthersConvert) {
    const TemporaryFolder folder;
    folder.write("in.ply", ascii_ply(egg_points(2000)));
    const ProgramRun version = run_program(folder, {"--version"});
    const bool has_cgal = version.out.find("without CGAL") == std::string::npos;
    for (const char* method : {"cocone", "tight-cocone", "robust-cocone"}) {
        const ProgramRun run =
            run_program(folder, {"in.ply", "out.glb", "--method", method, "--triangles", "100"});
        EXPECT_EQ(run.exit_code, has_cgal ? 0 : 2) << method << run.err;
        if (!has_cgal) {
            EXPECT_THAT(run.err, AllOf(HasSubstr("'" + std::string(method) + "' needs CGAL"),
                                       HasSubstr("implicit")));
        }
        EXPECT_EQ(std::filesystem::exists(folder / "out.glb"), has_cgal);
    }
    for (const char* surface : {"auto", "open", "watertight"})
        for (const char* method : {"auto", "implicit"}) {
            const ProgramRun run = run_program(folder, {"in.ply", "out.glb", "--method", method,
                                                        "--surface", surface, "--triangles", "99"});
            EXPECT_EQ(run.exit_code, 0) << surface << method << run.err;
        }
}

TEST(Usage, DumpedOptionsAreAConfigThatGivesThem) {
    const TemporaryFolder folder;
    const ProgramRun first =
        run_program(folder, {"--dump-options", "--triangles", "77", "--geometry-error", "3mm"});
    ASSERT_EQ(first.exit_code, 0) << first.err;
    EXPECT_EQ(nlohmann::json::parse(first.out)["triangles"], 77);
    folder.write("options.json", first.out);
    const ProgramRun second = run_program(folder, {"--dump-options", "--config", "options.json"});
    EXPECT_EQ(second.out, first.out);
    const ProgramRun flag =
        run_program(folder, {"--dump-options", "--config", "options.json", "--triangles", "78"});
    EXPECT_EQ(nlohmann::json::parse(flag.out)["triangles"], 78);
}

TEST(Usage, TheManualNamesEveryOption) {
    const TemporaryFolder folder;
    std::ifstream file(POINTBAKE_SOURCE "/docs/cli.md");
    std::stringstream manual;
    manual << file.rdbuf();
    const ProgramRun dump = run_program(folder, {"--dump-options"});
    const nlohmann::json options = nlohmann::json::parse(dump.out);
    for (const auto& [name, value] : options.items())
        EXPECT_THAT(manual.str(), HasSubstr("`--" + name)) << "docs/cli.md";
}

TEST(Usage, BadConfigsSayWhatIsWrong) {
    const TemporaryFolder folder;
    folder.write("bad.json", "{\"trangles\": 5}");
    const ProgramRun unknown = run_program(folder, {"in.ply", "--config", "bad.json"});
    EXPECT_EQ(unknown.exit_code, 2);
    EXPECT_THAT(unknown.err, HasSubstr("'triangles'"));
    EXPECT_EQ(run_program(folder, {"in.ply", "--config", "none.json"}).exit_code, 3);
}

TEST(Usage, DoesNotTakeASecondCloudForTheOutput) {
    const TemporaryFolder folder;
    folder.write("a.ply", ascii_ply(egg_points(50)));
    folder.write("b.ply", ascii_ply(egg_points(60)));
    const ProgramRun run = run_program(folder, {"a.ply", "b.ply"});
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.err, HasSubstr("-o"));
    EXPECT_EQ(folder.read("b.ply"), ascii_ply(egg_points(60)));
}

TEST(Usage, MemoryLimitIsCheckedBeforeTheWork) {
    const TemporaryFolder folder;
    folder.write("in.ply", ascii_ply(egg_points(1000)));
    const ProgramRun run = run_program(folder, {"in.ply", "--max-memory", "50M"});
    EXPECT_EQ(run.exit_code, 5);
    EXPECT_THAT(run.err, HasSubstr("--max-memory"));
    EXPECT_THAT(folder.files(), testing::ElementsAre("in.ply"));
}

}  // namespace
}  // namespace pointbake::cli
