// Whole conversions from file to file, and what they say about themselves.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "run_program.h"
#include "support/check_glb.h"

namespace pointbake::cli {
namespace {

using Json = nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

/// A folder with a small coloured ellipsoid in it.
class Conversion : public testing::Test {
 protected:
    Conversion() { folder_.write("in.ply", ascii_ply(egg_points(3000))); }

    ProgramRun run(const std::vector<std::string>& words) const {
        return run_program(folder_, words);
    }
    ProgramRun run_well(const std::vector<std::string>& words) const {
        ProgramRun done = run(words);
        EXPECT_EQ(done.exit_code, 0) << testing::PrintToString(words) << "\n" << done.err;
        return done;
    }

    TemporaryFolder folder_;
};

TEST_F(Conversion, WritesAGlbBesideTheInputAndASummaryToStderr) {
    const ProgramRun done = run_well({"in.ply"});
    EXPECT_THAT(folder_.files(), ElementsAre("in.glb", "in.ply"));
    EXPECT_THAT(folder_.read("in.glb"), testing::StartsWith("glTF"));
    EXPECT_EQ(done.out, "");
    EXPECT_THAT(done.err, HasSubstr("3,000 points"));
    EXPECT_THAT(done.err,
                testing::ContainsRegex("surface [a-z]+ by [a-z-]+: .* noise .* spacings"));
    EXPECT_THAT(done.err, HasSubstr("wrote in.glb"));
    EXPECT_THAT(done.err, testing::Not(HasSubstr("\033"))) << "a bar off the terminal";
}

TEST_F(Conversion, GoesOnWhereNobodyListens) {
    folder_.write("deaf", "");
    EXPECT_EQ(run({"in.ply", "-v", "-v", "--progress", "json"}).exit_code, 0);
    EXPECT_THAT(folder_.read("in.glb"), testing::StartsWith("glTF"));
    EXPECT_EQ(run({"nothere.ply"}).exit_code, 3);
    EXPECT_EQ(run({"--nosuch"}).exit_code, 2);
}

TEST_F(Conversion, SimplifyTellsThatTheTextureIsNotKept) {
    run_well({"in.ply", "out.glb", "--triangles", "300"});
    EXPECT_THAT(run_well({"simplify", "out.glb", "light.ply"}).err,
                HasSubstr("the texture and colours of out.glb are not kept"));
}

TEST_F(Conversion, TellsOfTheDenseMesh) {
    EXPECT_THAT(run_well({"reconstruct", "in.ply", "dense.ply"}).err,
                testing::ContainsRegex("3,000 points -> [0-9,]+ triangles in 1 piece with 0 "
                                       "borders"));
}

TEST_F(Conversion, TellsOfMergedRowsAndOfFacesThatAreNotUsed) {
    run_well({"reconstruct", "in.ply", "dense.ply"});
    const ProgramRun used = run_well({"-i", "dense.ply", "-o", "a.glb", "--surface", "given"});
    EXPECT_THAT(used.err, testing::Not(HasSubstr("--surface given would")));
    EXPECT_THAT(used.err, testing::Not(HasSubstr("noise")));
    const std::vector<std::string> words = {"-i", "dense.ply", "-o", "a.glb"};
    const std::string hint =
        "faces, of which only the corners are taken: --surface given would use them";
    EXPECT_THAT(run_well(words).err, HasSubstr(hint));
    EXPECT_THAT(run_well({"info", "dense.ply"}).out, HasSubstr(hint));

    std::vector<Vec3d> points = egg_points(1000);
    points.insert(points.end(), points.begin(), points.begin() + 20);
    folder_.write("twice.ply", ascii_ply(points));
    EXPECT_THAT(run_well({"reconstruct", "twice.ply", "b.ply"}).err,
                HasSubstr("merged 20 rows with the coordinates of another"));
}

TEST_F(Conversion, RefusesWhatAGivenSurfaceWouldIgnore) {
    run_well({"reconstruct", "in.ply", "dense.ply"});
    const std::vector<std::vector<std::string>> ignored = {{"--method", "implicit"},
                                                           {"--denoise", "on"},
                                                           {"--fill-holes", "1%"},
                                                           {"--surface", "open"}};
    for (const std::vector<std::string>& option : ignored)
        for (const std::vector<std::string>& given :
             {std::vector<std::string>{"--mesh", "dense.ply"}, {"--surface", "given"}}) {
            if (option[0] == given[0]) continue;
            std::vector<std::string> words = {"-i", "dense.ply", "-o", "a.glb"};
            words.insert(words.end(), given.begin(), given.end());
            words.insert(words.end(), option.begin(), option.end());
            const ProgramRun done = run(words);
            EXPECT_EQ(done.exit_code, 2) << testing::PrintToString(words);
            EXPECT_THAT(done.err, HasSubstr(option[0] + " "));
            EXPECT_THAT(done.err, HasSubstr("does not go with " + given[0]));
        }
}

TEST_F(Conversion, ASurfaceWithoutMostOfThePointsIsNone) {
    folder_.write("few.ply", ascii_ply(egg_points(20)));
    const ProgramRun done = run({"few.ply", "few.glb", "--method", "implicit"});
    EXPECT_EQ(done.exit_code, 3) << done.err;
    EXPECT_THAT(done.err, testing::ContainsRegex("few.ply: .* of 20 points.*another --surface"));
    EXPECT_THAT(folder_.files(), ElementsAre("few.ply", "in.ply"));
}

TEST_F(Conversion, DrawsWhatTheTexelsAreWhenAsked) {
    run_well({"in.ply", "out.glb", "--triangles", "300", "--debug-maps", "maps",
              "--debug-background", "ff00ff"});
    EXPECT_THAT(folder_.files(), ElementsAre("in.ply", "maps", "out.glb"));
    for (const char* name : {"coverage-0", "error-0", "density-0"})
        EXPECT_THAT(folder_.read(fmt::format("maps/{}.png", name)), testing::StartsWith("\x89PNG"));
}

TEST_F(Conversion, RefusesWhatIsNoColour) {
    const ProgramRun done = run({"in.ply", "--debug-background", "magenta"});
    EXPECT_EQ(done.exit_code, 2);
    EXPECT_THAT(done.err, HasSubstr("'magenta' is not a colour: expected six digits like ff00ff"));
}

TEST_F(Conversion, ChartsAreSampledWithMipLevelsAndTrianglesWithout) {
    run_well({"in.ply", "charts.glb", "--triangles", "300"});
    run_well({"in.ply", "triangles.glb", "--triangles", "300", "--atlas", "triangles"});
    EXPECT_THAT(folder_.read("charts.glb"), HasSubstr("\"minFilter\":9987"));
    EXPECT_THAT(folder_.read("triangles.glb"), HasSubstr("\"minFilter\":9729"));
    EXPECT_EQ(run({"in.ply", "--mips", "9"}).exit_code, 2);
}

TEST_F(Conversion, OverwritesAnOldOutput) {
    folder_.write("out.glb", "old");
    run_well({"in.ply", "out.glb", "--triangles", "200"});
    EXPECT_THAT(folder_.read("out.glb"), testing::StartsWith("glTF"));
}

TEST_F(Conversion, TheConvertWordAndNamedFilesDoTheSame) {
    run_well({"in.ply", "a.glb", "--triangles", "300"});
    run_well({"convert", "-o", "b.glb", "-i", "in.ply", "--triangles=300"});
    EXPECT_EQ(folder_.read("a.glb"), folder_.read("b.glb"));
}

TEST_F(Conversion, SeveralInputsAreOneCloud) {
    const std::vector<Vec3d> points = egg_points(3000);
    const std::vector<Vec3d> first(points.begin(), points.begin() + 1000);
    std::vector<Vec3d> second(points.begin() + 1000, points.end());
    folder_.write("first.ply", ascii_ply(first));
    folder_.write("second.ply", ascii_ply(second));
    run_well({"in.ply", "whole.glb", "--triangles", "300"});
    run_well({"first.ply", "second.ply", "parts.glb", "--triangles", "300"});
    EXPECT_EQ(folder_.read("whole.glb"), folder_.read("parts.glb"));

    second.push_back(second[3]);
    second.push_back(first[7]);
    second.push_back({std::numeric_limits<double>::infinity(), 0.0, 0.0});
    folder_.write("second.ply", ascii_ply(second));
    const ProgramRun done =
        run_well({"-i", "first.ply", "-i", "second.ply", "-o", "parts.glb", "--triangles", "300",
                  "--report", "-", "--write-points", "rows.ply"});
    const Json input = Json::parse(done.out)["input"];
    EXPECT_EQ(input["rows"], 3003);
    EXPECT_EQ(input["points"], 3000);
    EXPECT_EQ(input["defects"]["merged"], 2);
    EXPECT_EQ(input["defects"]["non_finite"], 1);
    EXPECT_THAT(folder_.read("rows.ply"), HasSubstr("element vertex 3003"));
}

TEST_F(Conversion, GivesTheSameBytesForAnyNumberOfThreads) {
    std::vector<Json> reports;
    for (const char* threads : {"1", "2", "7"}) {
        const ProgramRun done =
            run_well({"in.ply", "out.glb", "--threads", threads, "--report", "-"});
        reports.push_back(Json::parse(done.out));
        reports.back().erase("timings");
        folder_.write(threads, folder_.read("out.glb"));
    }
    EXPECT_EQ(folder_.read("1"), folder_.read("7"));
    EXPECT_EQ(folder_.read("1"), folder_.read("2"));
    EXPECT_EQ(reports[0], reports[1]);
    EXPECT_EQ(reports[0], reports[2]);
}

TEST_F(Conversion, ReportAgreesWithTheFiles) {
    const ProgramRun done = run_well({"in.ply", "out.glb", "--report", "report.json", "--triangles",
                                      "400", "--texels", "65536"});
    EXPECT_EQ(done.out, "");
    const Json report = Json::parse(folder_.read("report.json"));
    EXPECT_EQ(report["input"]["points"], 3000);
    EXPECT_LE(report["simplify"]["triangles"], 400);
    EXPECT_LE(report["atlas"]["texels"], 65536);
    EXPECT_EQ(report["write"]["bytes"], folder_.read("out.glb").size());
    EXPECT_EQ(report["options"]["triangles"], 400);
    EXPECT_TRUE(report["simplify"]["bound"].is_null());
    EXPECT_LE(report["simplify"]["point_distances"]["max"],
              report["simplify"]["points_to_mesh"]["max"].get<double>() + 1e-6);
    std::vector<std::string> stages;
    for (const Json& time : report["timings"]["stages"]) stages.push_back(time["stage"]);
    EXPECT_THAT(stages,
                ElementsAre("load", "attributes", "reconstruct", "simplify", "texture", "write"));
}

TEST_F(Conversion, QuietSaysNothing) { EXPECT_EQ(run_well({"in.ply", "out.glb", "-q"}).err, ""); }

TEST_F(Conversion, WorkDirectoryHoldsEveryStage) {
    run_well({"in.ply", "out.glb", "--work-dir", "a/steps"});
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "a/steps")) {
        names.push_back(entry.path().filename().string());
        EXPECT_GT(entry.file_size(), 0U) << names.back();
    }
    EXPECT_THAT(names, testing::UnorderedElementsAre(
                           "options.json", "1-attributes.ply", "2-reconstruct.ply",
                           "3-simplify.ply", "4-texture.glb", "4-texture-0.png", "report.json"));
    EXPECT_EQ(folder_.read("a/steps/4-texture.glb"), folder_.read("out.glb"));
    EXPECT_TRUE(Json::parse(folder_.read("a/steps/options.json")).is_object());
    EXPECT_TRUE(Json::parse(folder_.read("a/steps/report.json")).is_object());
}

TEST_F(Conversion, StopsAfterTheStageThatIsAskedFor) {
    run_well({"in.ply", "light.ply", "--stop-after", "simplify"});
    EXPECT_THAT(folder_.read("light.ply"), HasSubstr("element face"));
    run_well({"in.ply", "points.ply", "--stop-after", "attributes"});
    EXPECT_THAT(folder_.read("points.ply"), HasSubstr("nx"));
    EXPECT_THAT(folder_.read("points.ply"), testing::Not(HasSubstr("element face")));
    run_well({"in.ply", "loaded.ply", "--stop-after", "load"});
    EXPECT_THAT(folder_.read("loaded.ply"), HasSubstr("element vertex 3000"));
    run_well({"in.ply", "--stop-after", "reconstruct", "--work-dir", "work"});
    EXPECT_TRUE(std::filesystem::exists(folder_ / "work/2-reconstruct.ply"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "work/3-simplify.ply"));
}

TEST_F(Conversion, StagesOnFilesMakeUpTheWhole) {
    run_well({"reconstruct", "in.ply", "dense.ply"});
    run_well({"simplify", "dense.ply", "light.ply", "--triangles", "500", "--points", "in.ply"});
    run_well({"simplify", "dense.ply", "lone.ply", "--triangles", "500"});
    run_well({"texture", "light.ply", "in.ply", "model.glb"});
    EXPECT_THAT(folder_.read("lone.ply"), HasSubstr("element face"));
    EXPECT_THAT(folder_.read("model.glb"), testing::StartsWith("glTF"));
    const ProgramRun info = run_well({"info", "light.ply", "--json"});
    EXPECT_LE(Json::parse(info.out)["faces"], 500);
}

TEST_F(Conversion, KeepsTheTextureCoordinatesOfAGivenMesh) {
    run_well({"in.ply", "first.glb", "--triangles", "300"});
    run_well({"in.ply", "again.glb", "--mesh", "first.glb", "--keep-uvs"});
    const GlbContents first = check_glb(folder_ / "first.glb"),
                      again = check_glb(folder_ / "again.glb");
    EXPECT_THAT(again.problems, testing::IsEmpty());
    ASSERT_EQ(first.primitives.size(), 1U);
    ASSERT_EQ(again.primitives.size(), 1U);
    const auto corners = [](const GlbPrimitive& p) {
        std::vector<std::array<float, 5>> out;
        for (const auto& t : p.triangles)
            for (const std::uint32_t v : t) {
                const Vec3f x = p.stored_positions[v];
                out.push_back({x.x, x.y, x.z, p.uvs[v].x, p.uvs[v].y});
            }
        return out;
    };
    EXPECT_THAT(corners(again.primitives[0]),
                testing::UnorderedElementsAreArray(corners(first.primitives[0])));
    run_well({"texture", "first.glb", "in.ply", "same.glb", "--keep-uvs"});
    EXPECT_EQ(folder_.read("same.glb"), folder_.read("again.glb"));
}

TEST_F(Conversion, EveryMaterialOfAKeptLayoutGetsAPageOfItsShape) {
    run_well({"in.ply", "page.obj", "--triangles", "300"});  // for page.png
    folder_.write("two.mtl", "newmtl photo\nmap_Kd page.png\nnewmtl plain\nKd 1 0 0\n");
    folder_.write("two.obj",
                  "mtllib two.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n"
                  "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                  "usemtl photo\nf 1/1 2/2 3/3\nusemtl plain\nf 1/1 3/3 4/4\n");
    run_well({"texture", "two.obj", "in.ply", "two.glb", "--keep-uvs", "--texels", "200000"});
    const GlbContents file = check_glb(folder_ / "two.glb");
    EXPECT_THAT(file.problems, testing::IsEmpty());
    ASSERT_EQ(file.images.size(), 2U);
    const auto side = [&](std::size_t image, std::size_t byte) {
        return 256 * std::to_integer<int>(file.images[image][byte]) +
               std::to_integer<int>(file.images[image][byte + 1]);
    };
    EXPECT_EQ(side(1, 18), side(1, 22)) << "square without an image";
    EXPECT_GE(side(1, 18), std::max(side(0, 18), side(0, 22)));
    EXPECT_EQ(file.document["materials"][0]["name"], "photo");
    EXPECT_EQ(file.document["materials"][1]["name"], "plain");
}

// An OBJ of a tetrahedron around the egg.
std::string tetrahedron_obj(double size) {
    return fmt::format(
        "v 0 0 {0}\nv {0} 0 -{0}\nv -{0} {0} -{0}\nv -{0} -{0} -{0}\n"
        "f 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n",
        size);
}

TEST_F(Conversion, AMeshInAnotherPlaceOrUnitIsToldAbout) {
    folder_.write("mm.obj", tetrahedron_obj(2000.0));
    const ProgramRun none = run({"in.ply", "out.glb", "--mesh", "mm.obj"});
    EXPECT_EQ(none.exit_code, 6) << none.err;
    EXPECT_THAT(none.err, HasSubstr("same place and unit"));
    EXPECT_THAT(run_well({"texture", "mm.obj", "in.ply", "out.glb"}).err,
                HasSubstr("from the mesh in the mean"));
    folder_.write("near.obj", tetrahedron_obj(2.0));
    EXPECT_THAT(
        run_well({"in.ply", "out.glb", "--mesh", "near.obj", "--geometry-error", "0.3"}).err,
        testing::AllOf(HasSubstr("are left out"), HasSubstr("off the surface")));
    EXPECT_EQ(
        run({"in.ply", "strict.glb", "--mesh", "near.obj", "--geometry-error", "0.3", "--strict"})
            .exit_code,
        5);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "strict.glb"));
}

TEST_F(Conversion, WhatLooksLikeAnInputIsNotOverwrittenByASlip) {
    run_well({"reconstruct", "in.ply", "ours.ply"});
    run_well({"in.ply", "ours.ply"});
    std::string scan = folder_.read("ours.ply");
    scan.replace(scan.find("comment pointbake"), 17, "comment scannerXY");
    folder_.write("scan.ply", scan);
    EXPECT_EQ(run({"in.ply", "scan.ply"}).exit_code, 2);
    EXPECT_EQ(folder_.read("scan.ply"), scan);
    run_well({"in.ply", "-o", "scan.ply"});
    folder_.write("egg.obj", tetrahedron_obj(1.0));
    const ProgramRun shared = run({"texture", "egg.obj", "in.ply", "egg.gltf"});
    EXPECT_EQ(shared.exit_code, 2);
    EXPECT_THAT(shared.err, HasSubstr("choose another name"));
}

TEST_F(Conversion, SampleMakesPointsOfTheModelAgain) {
    run_well({"in.ply", "out.glb"});
    run_well({"sample", "out.glb", "again.ply", "--points", "1000"});
    const Json info = Json::parse(run_well({"info", "again.ply", "--json"}).out);
    EXPECT_NEAR(info["points"].get<double>(), 1000.0, 200.0);
    EXPECT_NEAR(info["diagonal"].get<double>(), 2.0 * std::sqrt(1.0 + 0.64 + 0.36), 0.1);
    EXPECT_THAT(folder_.read("again.ply"), HasSubstr("red"));
}

TEST_F(Conversion, AMissedBoundIsAWarningAndUnderStrictAnError) {
    const std::vector<std::string> words = {"in.ply",           "out.glb", "--triangles", "50",
                                            "--geometry-error", "0.1%",    "--report",    "r.json"};
    const ProgramRun lax = run_well(words);
    EXPECT_THAT(lax.err, HasSubstr("pointbake: warning: "));
    EXPECT_FALSE(Json::parse(folder_.read("r.json"))["simplify"]["bound_met"]);
    std::filesystem::remove(folder_ / "out.glb");
    std::vector<std::string> strict = words;
    strict.emplace_back("--strict");
    EXPECT_EQ(run(strict).exit_code, 5);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out.glb"));
}

TEST_F(Conversion, DryRunPlansAndWritesNothing) {
    const ProgramRun done = run_well({"in.ply", "out.glb", "--dry-run", "--triangles", "500",
                                      "--report", "r.json", "--work-dir", "work"});
    EXPECT_THAT(done.out,
                testing::AllOf(HasSubstr("3,000"), HasSubstr("500 triangles"), HasSubstr("MB")));
    EXPECT_THAT(folder_.files(), ElementsAre("in.ply"));
}

TEST_F(Conversion, WritePointsAccountsForEveryRow) {
    std::vector<Vec3d> points = egg_points(1000);
    points.push_back(points[0]);
    points.push_back({std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0});
    folder_.write("dirty.ply", ascii_ply(points));
    const ProgramRun done = run_well({"dirty.ply", "--write-points", "rows.ply", "--report", "-"});
    EXPECT_THAT(folder_.read("rows.ply"), HasSubstr("element vertex 1002"));
    const Json defects = Json::parse(done.out)["input"]["defects"];
    EXPECT_EQ(defects["merged"], 1);
    EXPECT_EQ(defects["non_finite"], 1);
}

TEST_F(Conversion, JsonProgressIsOneObjectPerLineAndGrows) {
    const ProgramRun done = run_well({"in.ply", "out.glb", "--progress", "json", "-q"});
    std::istringstream lines(done.err);
    double last = 0.0;
    int count = 0;
    for (std::string line; std::getline(lines, line); ++count) {
        const Json step = Json::parse(line);
        EXPECT_GE(step["total"].get<double>(), last) << line;
        last = step["total"];
    }
    EXPECT_GE(count, 4);
}

TEST_F(Conversion, InfoTellsWhatIsInAFile) {
    const ProgramRun done = run_well({"info", "in.ply"});
    EXPECT_THAT(done.out, testing::AllOf(HasSubstr("3,000"), HasSubstr("ascii"),
                                         HasSubstr("colors"), HasSubstr("spacing")));
    const Json json = Json::parse(run_well({"info", "in.ply", "--json"}).out);
    EXPECT_EQ(json["points"], 3000);
    EXPECT_NEAR(json["extent"][0].get<double>(), 2.0, 0.01);
}

TEST_F(Conversion, DemoMakesModelPointsAndPicture) {
    run_well({"demo", "made/here/demo.glb", "--points", "5000"});
    EXPECT_THAT(folder_.read("made/here/demo.glb"), testing::StartsWith("glTF"));
    EXPECT_THAT(folder_.read("made/here/demo-points.ply"), testing::StartsWith("ply"));
    EXPECT_THAT(folder_.read("made/here/demo-picture.png"), HasSubstr("PNG"));
}

TEST_F(Conversion, RenderDrawsCloudsAndModelsSideBySide) {
    run_well({"in.ply", "out.glb", "--triangles", "300"});
    const ProgramRun done = run_well({"render", "in.ply", "out.glb", "both.png", "--wires",
                                      "--width", "40", "--height", "30", "--transparent"});
    EXPECT_THAT(done.err, HasSubstr("wrote both.png, 120 x 30 pixels"));
    EXPECT_THAT(folder_.read("both.png"), testing::StartsWith("\x89PNG"));
    run_well({"render", "out.glb"});
    EXPECT_THAT(folder_.files(), ElementsAre("both.png", "in.ply", "out-picture.png", "out.glb"));
}

TEST_F(Conversion, RenderLooksFromAboveAndKnowsAxes) {
    const auto draw = [&](std::vector<std::string> words) {
        words.insert(words.begin(), {"render", "in.ply", "a.png", "--width", "40"});
        run_well(words);
        return folder_.read("a.png");
    };
    EXPECT_EQ(draw({"--direction", "0,1,0"}), draw({"--direction", "y", "--up", "-z"}));
    EXPECT_EQ(draw({"--up", "z"}), draw({"--up", "0,0,1"}));
    EXPECT_EQ(draw({}), draw({"--up", "y"}));
}

TEST_F(Conversion, RenderLeavesTexturesAlone) {
    for (const std::string extension : {"obj", "gltf"}) {
        const std::string model = extension + "." + extension;
        run_well({"in.ply", "-o", model, "--triangles", "300"});
        std::vector<std::string> textures;
        for (const std::string& name : folder_.files())
            if (name.starts_with(extension) && name.ends_with(".png")) textures.push_back(name);
        ASSERT_FALSE(textures.empty());
        const std::string before = folder_.read(textures[0]);
        EXPECT_EQ(run({"render", model, textures[0]}).exit_code, 2);
        run_well({"render", model});
        run_well({"render", model});  // over its own picture
        EXPECT_TRUE(folder_.read(textures[0]) == before);
    }
}

TEST_F(Conversion, LeavesStrangersBesideTheOutputAlone) {
    const std::vector<std::pair<std::string, std::vector<std::string>>> cases = {
        {"photo.png", {"in.ply", "photo.obj"}},
        {"photo.png", {"in.ply", "photo.gltf"}},
        {"photo.png", {"in.ply", "photo.ply"}},
        {"photo.jpg", {"in.ply", "photo.obj", "--texture-format", "jpeg"}},
        {"photo_0.png", {"in.ply", "photo.obj", "--page-size", "64", "--texels", "16k"}},
        {"photo.mtl", {"in.ply", "photo.obj", "--texels", "0"}},
        {"photo.bin", {"in.ply", "photo.gltf", "--stop-after", "simplify"}},
        {"photo.png", {"demo", "photo.obj", "--points", "3000"}},
    };
    for (const auto& [stranger, words] : cases) {
        folder_.write(stranger, "somebody's");
        const std::vector<std::string> before = folder_.files();
        const ProgramRun done = run(words);
        EXPECT_EQ(done.exit_code, 4) << testing::PrintToString(words) << done.err;
        EXPECT_THAT(done.err, HasSubstr(stranger + " is there already"));
        EXPECT_EQ(folder_.read(stranger), "somebody's");
        EXPECT_EQ(folder_.files(), before);
        std::filesystem::remove(folder_ / stranger);
    }
}

TEST_F(Conversion, OverwritesItsOwnTextures) {
    run_well({"in.ply", "own.obj", "--triangles", "300"});
    const std::string before = folder_.read("own.png");
    run_well({"in.ply", "own.obj", "--triangles", "200"});
    EXPECT_FALSE(folder_.read("own.png") == before);
}

TEST_F(Conversion, TellsThatNoAxisIsKnownToPointUp) {
    const std::string line = "axes: up not told";
    EXPECT_THAT(run_well({"in.ply", "a.glb"}).err, HasSubstr(line));
    EXPECT_THAT(run_well({"in.ply", "b.glb", "--up", "z"}).err, testing::Not(HasSubstr(line)));
}

TEST_F(Conversion, AWordThatIsNeitherFileNorCommandIsTold) {
    const ProgramRun done = run({"infoo", "in.ply"});
    EXPECT_EQ(done.exit_code, 2);
    EXPECT_THAT(done.err, HasSubstr("nearest command: info"));
    EXPECT_EQ(run({std::string(300, 'a')}).exit_code, 3);
}

}  // namespace
}  // namespace pointbake::cli
