#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <sstream>

#include "pointbake/write.h"
#include "write/write_fixtures.h"

namespace pointbake {
namespace {

using fixtures::error_of;
using fixtures::Folder;
using fixtures::read_text;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A binary little-endian PLY of one element without lists: every value as a double, by property.
struct PlyTable {
    std::string header;
    std::vector<std::string> names;
    std::vector<std::vector<double>> rows;

    explicit PlyTable(const std::filesystem::path& path) {
        const std::string text = read_text(path);
        std::size_t at = text.find("end_header\n") + 11;
        header = text.substr(0, at);
        std::istringstream lines(header);
        std::vector<std::string> types;
        std::size_t count = 0;
        for (std::string line; std::getline(lines, line);) {
            std::istringstream words(line);
            std::string key, type, name;
            words >> key >> type >> name;
            if (key == "element") count = std::stoul(name);
            if (key != "property") continue;
            types.push_back(type);
            names.push_back(name);
        }
        for (std::size_t i = 0; i < count; ++i) {
            rows.emplace_back();
            for (const std::string& type : types) rows.back().push_back(take(text, at, type));
        }
        EXPECT_EQ(at, text.size());
    }

    double value(std::size_t row, const std::string& name) const {
        const auto at = std::find(names.begin(), names.end(), name);
        EXPECT_NE(at, names.end()) << name;
        return rows.at(row).at(static_cast<std::size_t>(at - names.begin()));
    }
    std::vector<double> column(const std::string& name) const {
        std::vector<double> out;
        for (std::size_t i = 0; i < rows.size(); ++i) out.push_back(value(i, name));
        return out;
    }

 private:
    template <class T>
    static double take(const std::string& text, std::size_t& at) {
        T v;
        std::memcpy(&v, text.data() + at, sizeof v);
        at += sizeof v;
        return static_cast<double>(v);
    }
    static double take(const std::string& text, std::size_t& at, const std::string& type) {
        if (type == "double") return take<double>(text, at);
        if (type == "float") return take<float>(text, at);
        if (type == "uint") return take<std::uint32_t>(text, at);
        if (type == "ushort") return take<std::uint16_t>(text, at);
        EXPECT_EQ(type, "uchar");
        return take<std::uint8_t>(text, at);
    }
};

PointCloud two_points() {
    PointCloud cloud;
    cloud.positions = {{500000.1, 2, 3}, {4, 5, 6}};
    cloud.rows = {7, 1};
    return cloud;
}

TEST(Cloud, EveryAttributeAndChannelIsWritten) {
    const Folder folder;
    PointCloud cloud = two_points();
    cloud.colors = {{0, 257, 514}, {65535, 1, 2}};
    cloud.normals = {{0, 0, 1}, {0, 1, 0}};
    cloud.radii = {0.5F, 0.25F};
    cloud.areas = {3, 4};
    cloud.axes = {{{1, 2, 3}, {4, 5, 6}}, {{7, 8, 9}, {10, 11, 12}}};
    cloud.sensors = {{1, 0, 0}, {0, 1, 0}};
    cloud.weights = {1, 0.5F};
    cloud.channels.push_back({"my intensity", "dB", ChannelKind::kScalar, 1, {0.1F, 0.2F}});
    cloud.channels.push_back({"flow", "", ChannelKind::kVector, 2, {1, 2, 3, 4}});
    write_cloud(cloud, folder / "a.ply");
    const PlyTable table(folder / "a.ply");
    ASSERT_EQ(table.rows.size(), 2U);
    EXPECT_THAT(table.rows[0], ElementsAre(500000.1, 2, 3, 0, 0, 1, 0, 257, 514, 0.5, 3, 1, 2, 3, 4,
                                           5, 6, 1, 0, 0, 1, 7, 0.1F, 1, 2));
    EXPECT_EQ(table.value(1, "my_intensity"), 0.2F);
    EXPECT_EQ(table.value(1, "flow_1"), 4.0);
    EXPECT_EQ(table.value(1, "row"), 1.0);
    EXPECT_THAT(table.header, HasSubstr("comment unit my_intensity dB\n"));
}

TEST(Cloud, TypesAreAsSmallAsTheyCanBe) {
    const Folder folder;
    PointCloud cloud = two_points();
    cloud.positions[0].x = 0.5;
    cloud.colors = {{0, 257, 514}, {65535, 0, 0}};
    write_cloud(cloud, folder / "a.ply");
    const PlyTable table(folder / "a.ply");
    EXPECT_THAT(table.header, HasSubstr("float x"));
    EXPECT_THAT(table.header, HasSubstr("uchar red"));
    EXPECT_THAT(table.header, HasSubstr("uint row"));
    EXPECT_THAT(table.rows[0], ElementsAre(0.5, 2, 3, 0, 1, 2, 7));
    cloud.rows[0] = std::uint64_t{1} << 40;
    write_cloud(cloud, folder / "b.ply");
    EXPECT_EQ(PlyTable(folder / "b.ply").value(0, "row"), std::ldexp(1.0, 40));
}

TEST(Cloud, EmptyCloudIsAValidFile) {
    const Folder folder;
    write_cloud({}, folder / "a.ply");
    EXPECT_TRUE(PlyTable(folder / "a.ply").rows.empty());
}

TEST(Cloud, RefusesArraysThatDoNotFit) {
    const Folder folder;
    PointCloud cloud = two_points();
    cloud.normals.resize(1);
    const auto thrown = error_of([&] { write_cloud(cloud, folder / "a.ply"); });
    ASSERT_TRUE(thrown);
    EXPECT_EQ(thrown->code, ErrorCode::kInvalidInput);
    EXPECT_TRUE(folder.names().empty());
}

TEST(Points, EveryInputRowIsThereWithItsReason) {
    const Folder folder;
    PointCloud cloud;
    cloud.positions = {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
    cloud.rows = {5, 0, 2};
    cloud.dropped = {{3, {NAN, 0, 0}, DropReason::kNonFinite}};
    cloud.merged = {{1, 0}, {4, 2}};
    cloud.num_rows = 6;
    const std::vector<std::uint8_t> off_surface = {0, 0, 1};
    write_points(cloud, off_surface, folder / "a.ply");
    const PlyTable table(folder / "a.ply");
    EXPECT_THAT(table.column("row"), ElementsAre(0, 1, 2, 3, 4, 5));
    EXPECT_THAT(table.column("kept"), ElementsAre(1, 1, 0, 0, 0, 1));
    EXPECT_THAT(table.column("reason"), ElementsAre(0, 1, 3, 2, 3, 0));
    EXPECT_THAT(table.column("x"), ElementsAre(2, 2, 3, ::testing::IsNan(), 3, 1));
    EXPECT_THAT(table.header, HasSubstr("comment reason 3 off_surface\n"));
    EXPECT_THAT(table.header, HasSubstr("float x"));
}

TEST(Points, LargeCoordinatesAreDoubles) {
    const Folder folder;
    write_points(two_points(), {}, folder / "a.ply");
    const PlyTable table(folder / "a.ply");
    EXPECT_THAT(table.column("x"), ElementsAre(4, 500000.1));
    EXPECT_THAT(table.column("kept"), ElementsAre(1, 1));
}

TEST(Points, StopWhenCancelledAndLeaveNothing) {
    const Folder folder;
    std::stop_source stop;
    stop.request_stop();
    for (const bool all : {false, true}) {
        const auto thrown = error_of([&] {
            const Context context{.stop = stop.get_token()};
            if (all)
                write_points(two_points(), {}, folder / "a.ply", context);
            else
                write_cloud(two_points(), folder / "a.ply", context);
        });
        ASSERT_TRUE(thrown);
        EXPECT_EQ(thrown->code, ErrorCode::kCancelled);
        EXPECT_TRUE(folder.names().empty());
    }
}

}  // namespace
}  // namespace pointbake
