// Large coordinates from the file to the model, to the millimetre; axes, units and what is said of
// them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pointbake/vec.h"
#include "run_program.h"
#include "support/check_glb.h"

namespace pointbake::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr double kMillimetre = 0.001;

template <class T>
T value_at(const std::string& bytes, std::size_t at) {
    T value{};
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    return value;
}

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof(T));
}

/// LAS 1.2 of format 0 in steps of a tenth of a millimetre.
std::string las_file(const std::vector<Vec3d>& points, Vec3d offset) {
    constexpr double kStep = 1e-4;
    constexpr std::size_t kHeader = 227, kRecord = 20;
    std::string out(kHeader + kRecord * points.size(), '\0');
    out.replace(0, 4, "LASF");
    put<std::uint8_t>(out, 24, 1);
    put<std::uint8_t>(out, 25, 2);
    put<std::uint16_t>(out, 94, kHeader);
    put<std::uint32_t>(out, 96, kHeader);
    put<std::uint16_t>(out, 105, kRecord);
    put<std::uint32_t>(out, 107, static_cast<std::uint32_t>(points.size()));
    for (std::size_t k = 0; k < 3; ++k) {
        put(out, 131 + 8 * k, kStep);
        put(out, 155 + 8 * k, offset[k]);
        for (std::size_t i = 0; i < points.size(); ++i)
            put(out, kHeader + kRecord * i + 4 * k,
                static_cast<std::int32_t>(std::floor(points[i][k] / kStep + 0.5)));
    }
    return out;
}

/// Coordinates as an uncompressed LAS file has them, read here and not by the program.
std::vector<Vec3d> las_points(const std::string& bytes) {
    const std::size_t first = value_at<std::uint32_t>(bytes, 96);
    const std::size_t record = value_at<std::uint16_t>(bytes, 105);
    std::vector<Vec3d> points(value_at<std::uint32_t>(bytes, 107));
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k)
            points[i][k] = value_at<std::int32_t>(bytes, first + record * i + 4 * k) *
                               value_at<double>(bytes, 131 + 8 * k) +
                           value_at<double>(bytes, 155 + 8 * k);
    return points;
}

/// Of a binary PLY whose rows begin with three doubles.
std::vector<Vec3d> ply_points(const std::string& bytes, std::size_t row_bytes) {
    std::vector<Vec3d> points;
    std::size_t at = bytes.find("end_header\n") + 11;
    for (; at + row_bytes <= bytes.size(); at += row_bytes)
        points.push_back({value_at<double>(bytes, at), value_at<double>(bytes, at + 8),
                          value_at<double>(bytes, at + 16)});
    return points;
}

/// The largest distance from some 1 000 vertices, brought back by the documented formula and by
/// undoing the node transforms, to the nearest point of the source, in the source's units.
double largest_shift(const fs::path& model, const std::vector<Vec3d>& source) {
    const GlbContents file = check_glb(model);
    EXPECT_THAT(file.problems, testing::IsEmpty());
    const Json extras = file.document["nodes"][0]["extras"]["pointbake"];
    const Json shift = extras.value("global_shift", Json::array({0.0, 0.0, 0.0}));
    const double metres = extras.value("metres_per_unit", 1.0);
    const std::vector<Vec3f>& stored = file.primitives[0].stored_positions;
    EXPECT_GE(stored.size(), 1000U);
    double largest = 0.0;
    const std::size_t step = std::max<std::size_t>(1, stored.size() / 1000);
    for (std::size_t i = 0; i < stored.size(); i += step) {
        const Vec3d p =
            vec_cast<double>(stored[i]) +
            Vec3d{shift[0].get<double>(), shift[1].get<double>(), shift[2].get<double>()};
        const Vec3d scene = file.primitives[0].positions[i] / metres;  // x, z, -y
        EXPECT_LT(length(Vec3d{scene.x, -scene.z, scene.y} - p), 1e-6);
        double nearest = HUGE_VAL;
        for (const Vec3d& s : source) nearest = std::min(nearest, squared_length(s - p));
        largest = std::max(largest, std::sqrt(nearest));
    }
    return largest;
}

/// The dense mesh, whose vertices are points of the source.
ProgramRun dense(const TemporaryFolder& folder, const std::string& input,
                 const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {input, "out.glb", "--stop-after", "reconstruct", "--denoise",
                                      "off", "--thin",  "off",          "--method",    "cocone"};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramRun run = run_program(folder, words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run;
}

TEST(Georeference, UtmAndGeocentricCoordinatesLoseNothing) {
    for (const Vec3d offset :
         {Vec3d{453210.0, 5456789.0, 310.0}, Vec3d{4123456.0, 652345.0, 4805678.0}}) {
        const TemporaryFolder folder;
        std::vector<Vec3d> points = egg_points(1500);
        for (Vec3d& p : points) p = p * 40.0;
        folder.write("in.las", las_file(points, offset));
        const ProgramRun run = dense(folder, "in.las");
        EXPECT_THAT(run.err, AllOf(HasSubstr("global shift: "), HasSubstr("axes: z up: turned")));
        EXPECT_LT(largest_shift(folder / "out.glb", las_points(folder.read("in.las"))),
                  0.1 * kMillimetre);
    }
}

fs::path scan(const char* name) {
    const char* elsewhere = std::getenv("POINTBAKE_DATA");
    return fs::path(elsewhere ? elsewhere : POINTBAKE_SOURCE "/../shared/data") / "colored_points" /
           name;
}

TEST(Georeference, AutzenIsKeptToTheMillimetre) {
    const fs::path input = scan("autzen_trim.las");
    if (!fs::exists(input))
        GTEST_SKIP() << "no " << input << "; POINTBAKE_DATA names another folder";
    constexpr double kFoot = 0.3048;
    const TemporaryFolder folder;
    const ProgramRun run = dense(folder, input.string(),
                                 {"--crop", "636001,848935,406,636301,849235,521", "--report",
                                  "r.json", "--outliers", "keep", "--floaters", "keep"});
    std::ifstream file(input, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    EXPECT_LT(largest_shift(folder / "out.glb", las_points(bytes)), kMillimetre / kFoot);
    EXPECT_THAT(run.err, AllOf(HasSubstr("units: foot of 0.3048 m: scaled to metres by the node"),
                               HasSubstr("global shift: "), HasSubstr("CRS: NAD"),
                               HasSubstr("in out.prj"), HasSubstr("axes: z up: turned")));
    EXPECT_THAT(folder.read("out.prj"), AllOf(HasSubstr("PROJCS["), HasSubstr("0.3048")));
    const Json report = Json::parse(folder.read("r.json"));
    EXPECT_EQ(report["input"]["frame"]["unit"], "foot");
    EXPECT_EQ(report["write"]["frame"]["metres_per_unit"], kFoot);
    EXPECT_EQ(report["write"]["prj"], "out.prj");
    EXPECT_EQ(report["write"]["global_shift"].size(), 3U);
}

TEST(Georeference, OutcropIsKeptToTheMillimetre) {
    const fs::path input = scan("qcompass_outcrop.laz");
    if (!fs::exists(input))
        GTEST_SKIP() << "no " << input << "; POINTBAKE_DATA names another folder";
    const TemporaryFolder folder;
    const std::vector<std::string> part = {"--crop", "244404,6010939,18,244405.5,6010940.5,21"};
    dense(folder, input.string(), part);
    ASSERT_EQ(run_program(folder, {input.string(), "all.ply", "--stop-after", "load"}).exit_code,
              0);
    const std::string all = folder.read("all.ply");
    const std::size_t count = std::stoull(all.substr(all.find("element vertex ") + 15, 10));
    const std::size_t body = all.size() - all.find("end_header\n") - 11;
    EXPECT_LT(largest_shift(folder / "out.glb", ply_points(all, body / count)), kMillimetre);
}

TEST(Georeference, LengthsInMetresFollowTheUnitOfTheFile) {
    const TemporaryFolder folder;
    folder.write("in.ply", ascii_ply(egg_points(2000)));
    const auto bound = [&](const std::vector<std::string>& more) {
        std::vector<std::string> words = {"in.ply", "out.glb",  "--geometry-error",
                                          "20mm",   "--report", "r.json"};
        words.insert(words.end(), more.begin(), more.end());
        EXPECT_EQ(run_program(folder, words).exit_code, 0);
        return Json::parse(folder.read("r.json"))["simplify"]["bound"].get<double>();
    };
    EXPECT_NEAR(bound({}), 0.02, 1e-12);
    EXPECT_NEAR(bound({"--scale", "0.5"}), 0.04, 1e-12);
}

TEST(Georeference, OptionsOverruleTheFile) {
    const TemporaryFolder folder;
    folder.write("in.las", las_file(egg_points(1500), {1000.0, 1000.0, 100.0}));
    const ProgramRun run = dense(folder, "in.las", {"--up", "y", "--scale", "0.5"});
    EXPECT_THAT(run.err, AllOf(HasSubstr("axes: y up: as glTF has it (as --up says)"),
                               HasSubstr("units: unit of 0.5 m: scaled to metres by the node (as "
                                         "--scale says)")));
    const Json nodes = check_glb(folder / "out.glb").document["nodes"];
    EXPECT_FALSE(nodes[0].contains("rotation"));
    EXPECT_EQ(nodes[0]["scale"], Json::array({0.5, 0.5, 0.5}));
}

TEST(Georeference, InfoTellsTheFrame) {
    const TemporaryFolder folder;
    folder.write("in.las", las_file(egg_points(100), {453210.0, 5456789.0, 310.0}));
    const ProgramRun run = run_program(folder, {"info", "in.las"});
    EXPECT_THAT(run.out, AllOf(HasSubstr("up            z\n"), Not(HasSubstr("CRS"))));
    const Json json = Json::parse(run_program(folder, {"info", "in.las", "--json"}).out);
    EXPECT_EQ(json["frame"]["up"], "z");
    EXPECT_TRUE(json["frame"]["crs"]["name"].is_null());
    EXPECT_EQ(json["scanners"]["count"], 0);
    EXPECT_EQ(json["origin"], json["box"]["low"]);
    folder.write("in.pcd",
                 "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT "
                 "1\nVIEWPOINT 1 2 3 1 0 0 0\nPOINTS 2\nDATA ascii\n0 0 0\n1 1 1\n");
    EXPECT_THAT(run_program(folder, {"info", "in.pcd"}).out,
                AllOf(HasSubstr("scanners      1\n"), HasSubstr("scanner at    1 2 3\n"),
                      HasSubstr("up            not told\n")));
}

}  // namespace
}  // namespace pointbake::cli
