// PLY: which property goes where.
#include "core/color.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

using Names = std::array<const char*, 3>;

/// Three points whose colours are given by channel.
PointCloud with_colors(const std::string& format, const std::string& type, const Names& names,
                       const std::vector<double>& r, const std::vector<double>& g,
                       const std::vector<double>& b) {
    return load_bytes(
               make_ply(format, {three_points({column(type, names[2], b), column(type, names[0], r),
                                               column(type, names[1], g)})}))
        .cloud;
}

TEST(PlyAttributes, ReadsColorsOfAllNamesAndWidths) {
    struct Case {
        const char* type;
        Names names;
        double scale;  // from 8-bit values to the file's
    };
    for (const char* format : kFormats)
        for (const Case& c :
             {Case{"uchar", {"red", "green", "blue"}, 1}, Case{"uint8", {"r", "g", "b"}, 1},
              Case{"uchar", {"diffuse_red", "diffuse_green", "diffuse_blue"}, 1},
              Case{"uchar", {"Red", "Green", "Blue"}, 1},
              Case{"ushort", {"red", "green", "blue"}, 257},
              Case{"ushort", {"red", "green", "blue"}, 1}, Case{"int", {"red", "green", "blue"}, 1},
              Case{"float", {"red", "green", "blue"}, 1 / 255.0},
              Case{"double", {"r", "g", "b"}, 1 / 255.0}, Case{"float", {"r", "g", "b"}, 1}}) {
            SCOPED_TRACE(std::string(format) + " " + c.type + " " + c.names[0]);
            const PointCloud cloud =
                with_colors(format, c.type, c.names, {0 * c.scale, 255 * c.scale, 17 * c.scale},
                            {1 * c.scale, 254 * c.scale, 128 * c.scale},
                            {200 * c.scale, 3 * c.scale, 0 * c.scale});
            ASSERT_EQ(cloud.colors.size(), 3U);
            EXPECT_TRUE(cloud.channels.empty());
            EXPECT_EQ(cloud.colors[point_of_row(cloud, 0)], rgb16_from_8bit(0, 1, 200));
            EXPECT_EQ(cloud.colors[point_of_row(cloud, 1)], rgb16_from_8bit(255, 254, 3));
            EXPECT_EQ(cloud.colors[point_of_row(cloud, 2)], rgb16_from_8bit(17, 128, 0));
        }
}

TEST(PlyAttributes, KeepsSixteenBitColors) {
    const PointCloud cloud = with_colors("binary_big_endian", "ushort", {"red", "green", "blue"},
                                         {1, 2, 65535}, {258, 3, 4}, {5, 6, 7});
    EXPECT_EQ(cloud.colors[point_of_row(cloud, 0)], (Rgb16{1, 258, 5}));
}

TEST(PlyAttributes, ClampsColorsAndReadsSignedBytesAsUnsigned) {
    PointCloud cloud = with_colors("binary_little_endian", "char", {"red", "green", "blue"},
                                   {-1, 0, 127}, {-128, 1, 2}, {5, 6, 7});
    EXPECT_EQ(cloud.colors[point_of_row(cloud, 0)], rgb16_from_8bit(255, 128, 5));
    cloud = with_colors("ascii", "float", {"red", "green", "blue"}, {-0.5, 1.2, 0.5}, {0, 0, 0},
                        {0, 0, 1});
    EXPECT_EQ(cloud.colors[point_of_row(cloud, 0)].r, 0);
    EXPECT_EQ(cloud.colors[point_of_row(cloud, 1)].r, 65535);
    EXPECT_EQ(cloud.colors[point_of_row(cloud, 2)].r, 32768);
}

TEST(PlyAttributes, AlphaIsAChannel) {
    const PointCloud cloud =
        load_bytes(make_ply("ascii", {three_points({column("uchar", "red", {1, 2, 3}),
                                                    column("uchar", "green", {1, 2, 3}),
                                                    column("uchar", "blue", {1, 2, 3}),
                                                    column("uchar", "alpha", {255, 0, 9})})}))
            .cloud;
    ASSERT_NE(find_channel(cloud, "alpha"), nullptr);
    EXPECT_TRUE(cloud.weights.empty());
}

TEST(PlyAttributes, NormalizesNormalsAndCountsZeroOnes) {
    const LoadResult result = load_bytes(make_ply(
        "binary_little_endian",
        {three_points({column("float", "nx", {0, 3, 0}), column("double", "ny", {0, 0, 1e-200}),
                       column("float", "nz", {0, 4, 0})})}));
    const PointCloud& cloud = result.cloud;
    EXPECT_EQ(result.report.num_zero_normals, 2U);  // 1e-200 squared is zero
    EXPECT_EQ(cloud.normals[point_of_row(cloud, 1)], (Vec3f{0.6F, 0.0F, 0.8F}));
    EXPECT_EQ(cloud.normals[point_of_row(cloud, 0)], Vec3f{});
}

TEST(PlyAttributes, IgnoresNormalsThatAreAllZero) {
    const LoadResult result = load_bytes(make_ply(
        "ascii", {three_points({column("float", "nx", {0, 0, 0}), column("float", "ny", {0, 0, 0}),
                                column("float", "nz", {0, 0, 0})})}));
    EXPECT_TRUE(result.cloud.normals.empty());
    EXPECT_EQ(result.report.num_zero_normals, 3U);
}

TEST(PlyAttributes, ReadsSurfels) {
    for (const char* radius : {"radius", "psz"}) {
        const LoadResult result = load_bytes(make_ply(
            "binary_big_endian", {three_points({column("float", radius, {0.5, -1, 2}),
                                                column("float", "area", {1, 2, 3}),
                                                column("float", "weight", {0.25, 1, 0.5})})}));
        const PointCloud& cloud = result.cloud;
        EXPECT_EQ(cloud.radii[point_of_row(cloud, 0)], 0.5F);
        EXPECT_EQ(cloud.radii[point_of_row(cloud, 1)], 0.0F);
        EXPECT_EQ(cloud.areas[point_of_row(cloud, 2)], 3.0F);
        EXPECT_EQ(cloud.weights[point_of_row(cloud, 0)], 0.25F);
        EXPECT_EQ(result.report.notes.size(), 1U);  // the radius that is none
        EXPECT_TRUE(cloud.channels.empty());
    }
}

TEST(PlyAttributes, ReadsTangentAxesOfAllNames) {
    using Six = std::array<const char*, 6>;
    for (const Six& names :
         {Six{"u_x", "u_y", "u_z", "v_x", "v_y", "v_z"},
          Six{"tx1", "ty1", "tz1", "tx2", "ty2", "tz2"}, Six{"ux", "uy", "uz", "vx", "vy", "vz"}}) {
        std::vector<TestProperty> properties;
        for (std::size_t k = 0; k < 6; ++k) {
            const auto first = static_cast<double>(10 * k);
            properties.push_back(column("float", names[k], {first, first + 1, first + 2}));
        }
        const PointCloud cloud = load_bytes(make_ply("ascii", {three_points(properties)})).cloud;
        ASSERT_EQ(cloud.axes.size(), 3U);
        EXPECT_EQ(cloud.axes[point_of_row(cloud, 1)].u, (Vec3f{1, 11, 21}));
        EXPECT_EQ(cloud.axes[point_of_row(cloud, 1)].v, (Vec3f{31, 41, 51}));
        EXPECT_TRUE(cloud.sensors.empty());
    }
}

TEST(PlyAttributes, ReadsTheViewAxisAsSensorDirection) {
    for (const Names& names :
         {Names{"vx", "vy", "vz"}, Names{"sensor_x", "sensor_y", "sensor_z"}}) {
        const PointCloud cloud =
            load_bytes(make_ply("ascii", {three_points({column("float", names[0], {2, 0, 0}),
                                                        column("float", names[1], {0, 1, 0}),
                                                        column("float", names[2], {0, 0, 0})})}))
                .cloud;
        ASSERT_EQ(cloud.sensors.size(), 3U);
        EXPECT_EQ(cloud.sensors[point_of_row(cloud, 0)], (Vec3f{1, 0, 0}));
        EXPECT_EQ(cloud.sensors[point_of_row(cloud, 2)], Vec3f{});
    }
}

TEST(PlyAttributes, PutsOtherScalarsIntoChannels) {
    const PointCloud cloud =
        load_bytes(make_ply("binary_little_endian",
                            {three_points({column("float", "scalar_Intensity", {1, 2, 3}),
                                           column("uchar", "label", {4, 5, 6}),
                                           column("int", "scan", {7, 8, 9}),
                                           column("float", "scalar_Classification", {2, 2, 6}),
                                           column("float", "confidence", {0, 1, 2}),
                                           column("float", "weight", {0, 1, 2})})}))
            .cloud;
    ASSERT_EQ(cloud.channels.size(), 6U);
    EXPECT_EQ(cloud.channels[0].name, "scalar_Intensity");
    EXPECT_EQ(cloud.channels[0].kind, ChannelKind::kScalar);
    EXPECT_EQ(cloud.channels[1].kind, ChannelKind::kCategory);
    EXPECT_EQ(cloud.channels[2].kind, ChannelKind::kCategory);
    EXPECT_EQ(cloud.channels[3].kind, ChannelKind::kCategory);
    EXPECT_EQ(cloud.channels[2].data[point_of_row(cloud, 1)], 8.0F);
    EXPECT_TRUE(cloud.weights.empty()) << "0 and 2 are no weights";
}

TEST(PlyAttributes, ReadsGaussianSplatsAsPoints) {
    const LoadResult result = load_bytes(make_ply(
        "binary_little_endian",
        {three_points({column("float", "f_dc_0", {0, 10, -10}),
                       column("float", "f_dc_1", {1, 0, 0}), column("float", "f_dc_2", {0, 0, 0}),
                       column("float", "f_rest_0", {0, 0, 0}),
                       column("float", "opacity", {-3, 0, 3})})}));
    const PointCloud& cloud = result.cloud;
    const Rgb16 first = cloud.colors[point_of_row(cloud, 0)];
    EXPECT_EQ(first.r, 32768);
    EXPECT_NEAR(first.g, (0.5 + 0.28209479) * 65535, 1.0);
    EXPECT_EQ(cloud.colors[point_of_row(cloud, 1)].r, 65535);
    EXPECT_EQ(cloud.colors[point_of_row(cloud, 2)].r, 0);
    ASSERT_EQ(cloud.channels.size(), 1U);
    EXPECT_EQ(cloud.channels[0].name, "opacity");
    EXPECT_EQ(result.report.notes.size(), 1U);
}

}  // namespace
}  // namespace pointbake::test
