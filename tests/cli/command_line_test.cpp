#include "command_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pointbake/convert.h"
#include "pointbake/write.h"
#include "run_options.h"

namespace pointbake::cli {
namespace {

struct Parsed {
    SimplifyOptions simplify;
    WriteOptions write;
    FileOptions files;
    OptionTable table;
    ParsedLine line;

    explicit Parsed(const std::vector<std::string>& words) {
        table.add(OptionGroup::kGeometry, true, simplify);
        table.add(OptionGroup::kOutput, true, write);
        table.add(OptionGroup::kOutput, false, files);
        line = parse_line(words, table);
    }
};

std::string error_of(const std::vector<std::string>& words) {
    try {
        const Parsed parsed(words);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kInvalidOption);
        return error.what();
    }
    return "nothing was thrown";
}

TEST(CommandLine, ReadsFilesAndOptionsInAnyOrder) {
    const Parsed p({"--triangles", "500", "in.ply", "--scale=2", "out.glb", "-v", "--keep-mesh"});
    EXPECT_THAT(p.line.files, testing::ElementsAre("in.ply", "out.glb"));
    EXPECT_EQ(p.simplify.triangles, 500U);
    EXPECT_EQ(p.write.scale, 2.0);
    EXPECT_TRUE(p.simplify.keep_mesh);
    EXPECT_EQ(p.line.verbosity, 1);
}

TEST(CommandLine, ReadsNamedInputsAndOutput) {
    const Parsed p({"-i", "a.ply", "--output", "o.glb", "-i", "b.ply", "-q"});
    EXPECT_THAT(p.line.inputs, testing::ElementsAre("a.ply", "b.ply"));
    EXPECT_EQ(p.line.output, "o.glb");
    EXPECT_TRUE(p.line.files.empty());
    EXPECT_EQ(p.line.verbosity, -1);
}

TEST(CommandLine, TakesDashAsAValueAndALaterValueOverAnEarlier) {
    const Parsed p({"in.ply", "--report", "-", "--triangles", "1", "--triangles", "2"});
    EXPECT_EQ(p.files.report, "-");
    EXPECT_EQ(p.simplify.triangles, 2U);
}

TEST(CommandLine, FlagsCanBeSwitchedOff) {
    EXPECT_FALSE(Parsed({"--keep-mesh=false"}).simplify.keep_mesh);
}

TEST(CommandLine, NamesTheNearestOptionForAnUnknownOne) {
    EXPECT_THAT(error_of({"in.ply", "--trangles", "5"}),
                testing::AllOf(testing::HasSubstr("--trangles"),
                               testing::HasSubstr("nearest: --triangles")));
    EXPECT_THAT(error_of({"--verbos"}), testing::HasSubstr("--verbose"));
    EXPECT_THAT(error_of({"-x"}), testing::HasSubstr("unknown option -x"));
}

TEST(CommandLine, AnOptionWithoutItsValueIsAnError) {
    EXPECT_THAT(error_of({"in.ply", "--triangles"}), testing::HasSubstr("--triangles"));
}

TEST(Help, ShowsEveryOptionWithItsDefaultWithinTheWidth) {
    const Parsed p({});
    const std::string help = help_text({"pointbake INPUT", "Summary."}, p.table);
    for (const std::string_view name : p.table.names())
        EXPECT_THAT(help, testing::HasSubstr("--" + std::string(name)));
    EXPECT_THAT(help, testing::HasSubstr("[unlit]"));
    EXPECT_THAT(help, testing::HasSubstr("\nGeometry\n"));
    EXPECT_THAT(help, testing::Not(testing::HasSubstr("\nAtlas\n")));
    std::istringstream lines(help);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100U) << line;
}

}  // namespace
}  // namespace pointbake::cli
