// What the program reads beside PLY: text with named columns, packed files, standard input.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "run_program.h"

namespace pointbake::cli {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

const std::string kTable = "0.5 0 0 9 255 0 0\n1 1 1 8 0 255 0\n2 5 2 7 0 0 255\n";

Json info(const TemporaryFolder& folder, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"info", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramRun run = run_program(folder, words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return Json::parse(run.out, nullptr, false);
}

TEST(Reading, TheOptionNamesColumns) {
    const TemporaryFolder folder;
    folder.write("a.txt", kTable);
    EXPECT_THAT(info(folder, {"a.txt"}).dump(), HasSubstr("x,y,z,intensity,red,green,blue"));
    EXPECT_THAT(info(folder, {"a.txt", "--columns", "z,y,x,-,red,green,blue"}).dump(),
                HasSubstr("columns are z,y,x,-,red,green,blue, by --columns"));
    EXPECT_THAT(run_program(folder, {"a.txt", "out.ply", "--stop-after", "load"}).err,
                HasSubstr("columns are x,y,z,intensity,red,green,blue, by what they hold"));
    folder.write("a.ply", ascii_ply(egg_points(100)));
    EXPECT_THAT(info(folder, {"a.ply", "--columns", "x,y,z"}).dump(),
                HasSubstr("--columns not used"));
    for (const char* columns : {"x,y", "x,y,z,z", "x;y;z", "x,y,z,a,b,c,d,e"}) {
        const ProgramRun run = run_program(folder, {"info", "a.txt", "--columns", columns});
        EXPECT_EQ(run.exit_code, 2) << columns;
        EXPECT_THAT(run.err, HasSubstr("columns: "));
    }
}

TEST(Reading, StandardInputIsAFile) {
    const TemporaryFolder folder;
    folder.write("stdin", kTable);
    const Json json = info(folder, {"-"});
    EXPECT_THAT(json.dump(), HasSubstr("text, 7 columns"));
    folder.write("stdin", ascii_ply(egg_points(300)));
    EXPECT_EQ(run_program(folder, {"-", "out.glb", "--triangles", "200"}).exit_code, 0);
    EXPECT_THAT(folder.read("out.glb"), HasSubstr("glTF"));
    const ProgramRun nameless = run_program(folder, {"-"});
    EXPECT_EQ(nameless.exit_code, 2);
    EXPECT_THAT(nameless.err, HasSubstr("name the output with -o"));
    folder.write("stdin", "");
    const ProgramRun empty = run_program(folder, {"info", "-"});
    EXPECT_EQ(empty.exit_code, 3);
    EXPECT_THAT(empty.err, HasSubstr("-: the file is empty"));
}

TEST(Reading, UnknownFilesAreUnreadable) {
    const TemporaryFolder folder;
    for (const auto& [name, content] :
         {std::pair{"a.xyz", "hello\n"}, std::pair{"a.pcd", "VERSION .7\n"},
          std::pair{"a.ptx", "1\n1\n"}, std::pair{"a.off", "OFF\n9 9 9\n"},
          std::pair{"a.stl", "solid\n"}, std::pair{"a.splat", "x"}, std::pair{"a.spz", "NGSP"},
          std::pair{"a.gz", "\x1f\x8b\x08"}}) {
        folder.write(name, content);
        const ProgramRun run = run_program(folder, {name, "out.glb"});
        EXPECT_EQ(run.exit_code, 3) << name << run.err;
        EXPECT_THAT(run.err, HasSubstr(name));
    }
}

}  // namespace
}  // namespace pointbake::cli
