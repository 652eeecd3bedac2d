// Axes, units and coordinate systems as the files tell them.
#include <gmock/gmock.h>

#include "io/crs.h"
#include "io/las_files.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

using testing::HasSubstr;

constexpr double kFoot = 0.3048, kSurveyFoot = 1200.0 / 3937.0;

const std::string kUtm =
    R"(PROJCS["WGS 84 / UTM zone 32N",GEOGCS["WGS 84",DATUM["WGS_1984",)"
    R"(SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],)"
    R"(UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],)"
    R"(PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",9],)"
    R"(PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],)"
    R"(PARAMETER["false_northing",0],UNIT["metre",1],AUTHORITY["EPSG","32632"]])";

std::string las_with(const std::vector<TestVlr>& vlrs) {
    return TestLas{4, 0, vlrs, las_record(0, {1, 2, 3}) + las_record(0, {4, 5, 6})}.bytes();
}

TestVlr wkt_vlr(const std::string& wkt) { return {"LASF_Projection", 2112, wkt}; }

/// Keys and values of GeoTIFF; texts are (key, offset, length).
std::vector<TestVlr> key_vlrs(const std::vector<std::array<std::uint16_t, 4>>& keys,
                              const std::string& texts = "") {
    std::string data(8 * (keys.size() + 1), '\0');
    put<std::uint16_t>(data, 0, 1);
    put(data, 6, static_cast<std::uint16_t>(keys.size()));
    for (std::size_t i = 0; i < keys.size(); ++i)
        for (std::size_t k = 0; k < 4; ++k) put(data, 8 * (i + 1) + 2 * k, keys[i][k]);
    return {{"LASF_Projection", 34735, data}, {"LASF_Projection", 34737, texts}};
}

std::vector<std::string> warnings_of(const std::string& bytes) {
    std::vector<std::string> lines;
    const Context context{.log = [&](LogLevel level, std::string_view line) {
        if (level == LogLevel::kWarning) lines.emplace_back(line);
    }};
    load_as("a.las", bytes, {}, context);
    return lines;
}

TEST(Frame, LasTellsItsSystemAsWkt) {
    const Frame frame = load_as("a.las", las_with({wkt_vlr(kUtm)})).cloud.frame;
    EXPECT_EQ(frame.crs.name, "WGS 84 / UTM zone 32N");
    EXPECT_EQ(frame.crs.epsg, 32632);
    EXPECT_EQ(frame.unit, "metre");
    EXPECT_EQ(frame.metres_per_unit, 1.0);
    EXPECT_FALSE(frame.crs.is_geographic);
    EXPECT_THAT(frame.crs.wkt, testing::StartsWith("PROJCS[\"WGS_1984_UTM_Zone_32N\""));
}

TEST(Frame, LasTellsItsSystemAsKeys) {
    // projected, by code
    const Frame oregon =
        load_as("a.las", las_with(key_vlrs({{1024, 0, 1, 1}, {3072, 0, 1, 2994}}))).cloud.frame;
    EXPECT_EQ(oregon.crs.epsg, 2994);
    EXPECT_EQ(oregon.metres_per_unit, kFoot);
    EXPECT_EQ(oregon.unit, "foot");
    EXPECT_THAT(oregon.crs.wkt, testing::StartsWith("PROJCS["));
    // of the file's own making: a name and a unit
    const std::string texts = "My site|rest|";
    const Frame own = load_as("a.las", las_with(key_vlrs({{1024, 0, 1, 1},
                                                          {3072, 0, 1, 32767},
                                                          {3073, 34737, 8, 0},
                                                          {3076, 0, 1, 9003},
                                                          {4096, 0, 1, 5703}},
                                                         texts)))
                          .cloud.frame;
    EXPECT_EQ(own.crs.name, "My site");
    EXPECT_EQ(own.crs.epsg, 0);
    EXPECT_TRUE(own.crs.wkt.empty());
    EXPECT_NEAR(own.metres_per_unit, kSurveyFoot, 1e-15);
    EXPECT_EQ(own.unit, "US survey foot");
    EXPECT_EQ(own.crs.vertical, "NAVD88 height");
    EXPECT_EQ(own.height_unit, "metre");
    // WKT wins
    std::vector<TestVlr> both = key_vlrs({{1024, 0, 1, 1}, {3072, 0, 1, 2994}});
    both.push_back(wkt_vlr(kUtm));
    EXPECT_EQ(load_as("a.las", las_with(both)).cloud.frame.crs.epsg, 32632);
}

TEST(Frame, AnglesAndMixedUnitsAreWarnings) {
    EXPECT_TRUE(warnings_of(las_with({wkt_vlr(kUtm)})).empty());
    const auto angles = key_vlrs({{1024, 0, 1, 2}, {2048, 0, 1, 4326}});
    EXPECT_THAT(warnings_of(las_with(angles)),
                testing::ElementsAre(HasSubstr("angles of WGS 84, no lengths")));
    const Frame frame = load_as("a.las", las_with(angles)).cloud.frame;
    EXPECT_EQ(frame.metres_per_unit, 0.0);
    EXPECT_EQ(frame.unit, "degree");
    const auto mixed = key_vlrs({{1024, 0, 1, 1}, {3072, 0, 1, 32632}, {4096, 0, 1, 6360}});
    EXPECT_THAT(warnings_of(las_with(mixed)),
                testing::ElementsAre(HasSubstr("heights are in US survey foot, x and y in metre")));
}

TEST(Frame, DamagedSystemsAreNotes) {
    for (const std::string& wkt : {std::string("PROJCS[\"cut off"), std::string("\xff\xfe[]]]")}) {
        const LoadResult result = load_as("a.las", las_with({wkt_vlr(wkt)}));
        EXPECT_EQ(result.cloud.size(), 2U);
        EXPECT_TRUE(has_note(result, "coordinate system not understood")) << wkt;
        EXPECT_TRUE(result.cloud.frame.crs.name.empty());
    }
    EXPECT_TRUE(
        has_note(load_as("a.las", las_with(key_vlrs({{3072, 0, 1, 1}}))), "EPSG:1 is not known"));
    EXPECT_TRUE(has_note(load_as("a.las", las_with(key_vlrs({{1024, 0, 1, 1}, {3076, 0, 1, 7}}))),
                         "7 is the code of no unit"));
    const auto degrees = key_vlrs({{1024, 0, 1, 1}, {3076, 0, 1, 9102}});
    EXPECT_TRUE(has_note(load_as("a.las", las_with(degrees)), "9102 is the code of no unit"));
    EXPECT_EQ(load_as("a.las", las_with(degrees)).cloud.frame.metres_per_unit, 0.0);
    // Texts and entries beyond what is there; the directory cut at every byte.
    const auto beyond = key_vlrs({{1024, 0, 1, 1}, {3073, 34737, 9000, 9000}}, "a");
    EXPECT_TRUE(load_as("a.las", las_with(beyond)).cloud.frame.crs.name.empty());
    for (std::size_t length = 0; length <= beyond[0].data.size(); ++length) {
        std::vector<TestVlr> cut = beyond;
        cut[0].data.resize(length);
        EXPECT_EQ(load_as("a.las", las_with(cut)).cloud.size(), 2U);
    }
    EXPECT_EQ(load_as("a.las", las_with({wkt_vlr(std::string(60000, '['))})).cloud.size(), 2U);
}

TEST(Frame, CodesAsTextAreKnownToo) {
    Frame frame;
    EXPECT_EQ(add_crs(frame, "EPSG:25832"), "");
    EXPECT_EQ(frame.crs.name, "ETRS89 / UTM zone 32N");
    EXPECT_THAT(add_crs(frame, "EPSG:1"), HasSubstr("not understood"));
    EXPECT_EQ(add_crs(frame, " \n"), "");
}

TEST(Frame, EachKindOfFileHasItsAxes) {
    const std::string table = "0 0 0\n1 0 0\n0 1 0\n";
    const std::string ptx =
        "1\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n"
        "4 5 6 0.5\n";
    const std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n1 2 3\n";
    const auto up = [](const std::string& name, const std::string& bytes) {
        return load_as(name, bytes).cloud.frame.up;
    };
    EXPECT_EQ(up("a.las", las_with({})), UpAxis::kZ);
    EXPECT_EQ(up("a.ptx", ptx), UpAxis::kZ);
    EXPECT_EQ(up("a.pts", table), UpAxis::kZ);
    EXPECT_EQ(up("a.xyz", table), UpAxis::kAuto);
    EXPECT_EQ(up("a.ply", ply), UpAxis::kAuto);
    EXPECT_EQ(up("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), UpAxis::kAuto);
}

TEST(Frame, FilesThatDifferAreTakenForTheFirst) {
    std::vector<std::string> lines;
    const Context context{.log = [&](LogLevel level, std::string_view line) {
        if (level == LogLevel::kWarning) lines.emplace_back(line);
    }};
    const auto part = [&](const std::string& wkt) {
        return load_as("a.las", las_with({wkt_vlr(wkt)}));
    };
    EXPECT_EQ(merge_clouds({part(kUtm), part(kUtm)}, context).cloud.frame.crs.epsg, 32632);
    EXPECT_TRUE(lines.empty());
    EXPECT_EQ(merge_clouds({part("EPSG:2994"), part(kUtm)}, context).cloud.frame.crs.epsg, 2994);
    EXPECT_THAT(lines, testing::ElementsAre(HasSubstr("the files differ")));
}

}  // namespace
}  // namespace pointbake::test
