// E57: pages, packets, coded numbers, poses, files that lie.

#include "core/color.h"
#include "io/e57_pages.h"
#include "io/las_files.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

constexpr std::size_t kPage = 1024, kInPage = kPage - 4;

template <class T>
std::string raw(T value) {
    std::string out(sizeof(T), '\0');
    put(out, 0, value);
    return out;
}

std::string doubles(const std::vector<double>& values) {
    std::string out;
    for (const double v : values) out += raw(v);
    return out;
}

std::uint64_t byte_of_file(std::size_t at) { return at / kInPage * kPage + at % kInPage; }

/// Puts checksums between the pages.
std::string as_pages(std::string content) {
    content.resize((content.size() + kInPage - 1) / kInPage * kInPage);
    std::string out;
    for (std::size_t at = 0; at < content.size(); at += kInPage) {
        const std::string page = content.substr(at, kInPage);
        const std::uint32_t crc = crc32c(std::as_bytes(std::span(page)));
        out += page;
        for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(crc >> shift & 255U);
    }
    return out;
}

/// Streams in packets of at most `most` bytes of each, with an index and an empty one between.
std::string packets(const std::vector<std::string>& streams, std::size_t most) {
    std::string out;
    std::size_t longest = 0;
    for (const std::string& s : streams) longest = std::max(longest, s.size());
    for (std::size_t from = 0; from < longest; from += most) {
        std::string lengths, data;
        for (const std::string& s : streams) {
            const std::string part = from < s.size() ? s.substr(from, most) : "";
            lengths += raw(static_cast<std::uint16_t>(part.size()));
            data += part;
        }
        std::string packet =
            "\1" + std::string(3, '\0') + raw(static_cast<std::uint16_t>(streams.size()));
        packet += lengths + data;
        packet.resize((packet.size() + 3) / 4 * 4);
        put(packet, 2, static_cast<std::uint16_t>(packet.size() - 1));
        out += packet;
        out += raw<std::uint16_t>(0) + raw<std::uint16_t>(15) + std::string(12, '\7');
        out += raw<std::uint16_t>(2) + raw<std::uint16_t>(3);
    }
    return out;
}

struct TestScan {
    std::uint64_t num_points = 0;
    std::string fields;  ///< the prototype
    std::vector<std::string> streams;
    std::string more;  ///< pose, limits
    std::size_t packet_bytes = 7;
};

std::string field(const std::string& name, const std::string& attributes) {
    return "<" + name + " type=" + attributes + "/>\n";
}

const std::string kXyz = field("cartesianX", "\"Float\"") + field("cartesianY", "\"Float\"") +
                         field("cartesianZ", "\"Float\"");

std::string make_e57(const std::vector<TestScan>& scans, const std::string& more = "") {
    std::string content(48, '\0'), xml =
                                       "<?xml version=\"1.0\"?>\n<e57Root type=\"Structure\">\n"
                                       "<data3D type=\"Vector\">\n";
    content.replace(0, 8, "ASTM-E57");
    for (const TestScan& scan : scans) {
        content.resize((content.size() + 3) / 4 * 4);
        const std::size_t at = content.size();
        const std::string data = packets(scan.streams, scan.packet_bytes);
        content += raw<std::uint64_t>(1) + raw<std::uint64_t>(32 + data.size()) +
                   raw(byte_of_file(at + 32)) + raw<std::uint64_t>(0) + data;
        xml += "<vectorChild type=\"Structure\">" + scan.more +
               "<points type=\"CompressedVector\" fileOffset=\"" +
               std::to_string(byte_of_file(at)) + "\" recordCount=\"" +
               std::to_string(scan.num_points) + "\"><prototype type=\"Structure\">" + scan.fields +
               "</prototype></points></vectorChild>\n";
    }
    xml += "</data3D>" + more + "</e57Root>\n";
    put<std::uint32_t>(content, 8, 1);
    put(content, 24, byte_of_file(content.size()));
    put<std::uint64_t>(content, 32, xml.size());
    put<std::uint64_t>(content, 40, kPage);
    content += xml;
    put<std::uint64_t>(content, 16, (content.size() + kInPage - 1) / kInPage * kPage);
    return as_pages(content);
}

TestScan two_points() { return {2, kXyz, {doubles({1, 4}), doubles({2, 5}), doubles({3, 6})}, ""}; }

/// Integers of some bits each, the lowest first.
std::string packed(const std::vector<std::uint64_t>& values, unsigned num_bits) {
    std::string out((values.size() * num_bits + 7) / 8, '\0');
    for (std::size_t i = 0; i < values.size() * num_bits; ++i)
        if ((values[i / num_bits] >> i % num_bits & 1U) != 0)
            out[i / 8] = static_cast<char>(out[i / 8] | 1 << i % 8);
    return out;
}

TEST(E57, ReadsPointsOverPagesAndPackets) {
    std::vector<double> x, y, z;
    for (int i = 0; i < 300; ++i) {
        x.push_back(i + 1);
        y.push_back(i * 0.5);
        z.push_back(i % 7);
    }
    for (const std::size_t packet_bytes : {5U, 64U, 4000U}) {
        const std::string bytes =
            make_e57({{300, kXyz, {doubles(x), doubles(y), doubles(z)}, "", packet_bytes}});
        for (const int threads : {1, 3}) {
            const LoadResult result = load_as("a.bin", bytes, {}, {.threads = threads});
            ASSERT_EQ(result.cloud.size(), 300U);
            EXPECT_EQ(result.report.format, "E57");
            for (std::size_t i = 0; i < 300; ++i)
                EXPECT_EQ(result.cloud.positions[point_of_row(result.cloud, i)],
                          (Vec3d{x[i], y[i], z[i]}));
            EXPECT_TRUE(result.cloud.sensors.empty());
        }
    }
}

TEST(E57, ReadsNumbersOfAnyNumberOfBits) {
    for (const unsigned bits : {1U, 3U, 8U, 19U, 33U, 57U, 63U, 64U}) {
        SCOPED_TRACE(bits);
        const bool is_all = bits == 64;
        const std::string range =
            is_all ? "\"Integer\""
                   : "\"Integer\" minimum=\"-5\" maximum=\"" +
                         std::to_string(static_cast<std::int64_t>((1ULL << bits) - 1) - 5) + "\"";
        std::vector<std::uint64_t> steps;
        for (std::uint64_t i = 0; i < 20; ++i)
            steps.push_back((i * 0x9e3779b97f4a7c15ULL) >> (64 - bits));
        TestScan scan{20, field("value", range) + kXyz, {packed(steps, bits)}, ""};
        for (int k = 0; k < 3; ++k) {
            std::vector<double> numbers;
            for (int i = 0; i < 20; ++i) numbers.push_back(1 + i);
            scan.streams.push_back(doubles(numbers));
        }
        const LoadResult result = load_as("a.e57", make_e57({scan}));
        const Channel* channel = find_channel(result.cloud, "value");
        ASSERT_NE(channel, nullptr);
        for (std::size_t i = 0; i < 20; ++i) {
            const auto least = is_all ? std::int64_t{1} << 63 : std::int64_t{-5};
            const auto value =
                static_cast<std::int64_t>(static_cast<std::uint64_t>(least) + steps[i]);
            EXPECT_EQ(channel->data[point_of_row(result.cloud, i)],
                      static_cast<float>(static_cast<double>(value)));
        }
    }
}

TEST(E57, ScalesIntegersAndTakesSingleFloats) {
    const std::string fields =
        field("cartesianX",
              "\"ScaledInteger\" minimum=\"-100\" maximum=\"100\" scale=\"0.25\" "
              "offset=\"1000000\"") +
        field("cartesianY", "\"Float\" precision=\"single\"") +
        field("cartesianZ", "\"Integer\" minimum=\"7\" maximum=\"7\"");
    const LoadResult result = load_as(
        "a.e57", make_e57({{2, fields, {packed({0, 200}, 8), raw(1.5F) + raw(-2.5F), ""}, ""}}));
    EXPECT_EQ(result.cloud.positions[point_of_row(result.cloud, 0)], (Vec3d{999975, 1.5, 7}));
    EXPECT_EQ(result.cloud.positions[point_of_row(result.cloud, 1)], (Vec3d{1000025, -2.5, 7}));
}

TEST(E57, MovesScansByTheirPoses) {
    TestScan turned = two_points();  // a quarter turn about z
    turned.fields += field("nor:normalX", "\"Float\"") + field("nor:normalY", "\"Float\"") +
                     field("nor:normalZ", "\"Float\"");
    for (const std::vector<double>& n : {std::vector<double>{1, 0}, {0, 0}, {0, 1}})
        turned.streams.push_back(doubles(n));
    TestScan plain = turned;
    turned.more =
        "<pose type=\"Structure\"><rotation type=\"Structure\"><w type=\"Float\">2</w><x "
        "type=\"Float\"/><y type=\"Float\"/><z type=\"Float\">+2.0e0</z></rotation><translation "
        "type=\"Structure\"><x type=\"Float\">500000</x><y type=\"Float\">0</y><z "
        "type=\"Float\">10</z></translation></pose>";
    const LoadResult result =
        load_as("a.e57", make_e57({turned, plain, {0, kXyz, {"", "", ""}, ""}}));
    const PointCloud& cloud = result.cloud;
    ASSERT_EQ(cloud.size(), 4U);
    const std::size_t i = point_of_row(cloud, 0);
    EXPECT_NEAR(cloud.positions[i].x, 499998, 1e-9);
    EXPECT_NEAR(cloud.positions[i].y, 1, 1e-12);
    EXPECT_EQ(cloud.positions[i].z, 13);
    EXPECT_NEAR(cloud.normals[i].y, 1.0F, 1e-6F);
    EXPECT_EQ(cloud.positions[point_of_row(cloud, 3)], (Vec3d{4, 5, 6}));
    // The scanner is seen by the points of its own scan alone.
    EXPECT_NEAR(cloud.sensors[i].x, 2 / std::sqrt(14.0), 1e-6);
    EXPECT_EQ(cloud.sensors[point_of_row(cloud, 3)], Vec3f{});
    EXPECT_EQ(result.report.scanners, (std::vector<Vec3d>{{500000, 0, 10}}));
    EXPECT_TRUE(has_note(result, "3 scans, 2 of them with points"));
}

TEST(E57, ReadsSphericalCoordinates) {
    const std::string fields = field("sphericalRange", "\"Float\"") +
                               field("sphericalAzimuth", "\"Float\"") +
                               field("sphericalElevation", "\"Float\"");
    std::vector<double> range, azimuth, elevation;
    for (int i = 0; i < 200; ++i) {
        range.push_back(i == 0 ? 0.0 : 2.0 + i);
        azimuth.push_back((i - 100) * 0.0731);
        elevation.push_back((i % 41 - 20) * 0.0785);
    }
    const LoadResult result = load_as(
        "a.e57",
        make_e57({{200, fields, {doubles(range), doubles(azimuth), doubles(elevation)}, ""}}));
    EXPECT_EQ(result.report.num_left_out, 1U);
    for (std::size_t i = 1; i < 200; ++i) {
        const Vec3d p = result.cloud.positions[point_of_row(result.cloud, i)];
        const double r = range[i], a = azimuth[i], e = elevation[i];
        EXPECT_NEAR(p.x, r * std::cos(e) * std::cos(a), 1e-12);
        EXPECT_NEAR(p.y, r * std::cos(e) * std::sin(a), 1e-12);
        EXPECT_NEAR(p.z, r * std::sin(e), 1e-12);
    }
}

TEST(E57, ReadsColorsWithinTheirLimits) {
    const auto scan = [](const std::string& type, const std::vector<std::string>& colors,
                         const std::string& more) {
        TestScan out = two_points();
        for (std::size_t k = 0; k < 3; ++k) {
            out.fields += field(std::array{"colorRed", "colorGreen", "colorBlue"}[k], type);
            out.streams.push_back(colors[k]);
        }
        out.more = more;
        return make_e57({out});
    };
    const std::string bytes = "\"Integer\" minimum=\"0\" maximum=\"255\"";
    const std::vector<std::string> values{packed({255, 0}, 8), packed({0, 128}, 8),
                                          packed({0, 1}, 8)};
    const LoadResult eight = load_as("a.e57", scan(bytes, values, ""));
    EXPECT_EQ(eight.cloud.colors[point_of_row(eight.cloud, 0)], rgb16_from_8bit(255, 0, 0));
    EXPECT_EQ(eight.cloud.colors[point_of_row(eight.cloud, 1)], rgb16_from_8bit(0, 128, 1));
    std::string limits = "<colorLimits type=\"Structure\">";
    for (const std::string name : {"colorRed", "colorGreen", "colorBlue"})
        limits += "<" + name + "Minimum type=\"Integer\">0</" + name + "Minimum><" + name +
                  "Maximum type=\"Integer\">128</" + name + "Maximum>";
    const LoadResult limited = load_as("a.e57", scan(bytes, values, limits + "</colorLimits>"));
    EXPECT_EQ(limited.cloud.colors[point_of_row(limited.cloud, 1)], (Rgb16{0, 65535, 512}));
    const LoadResult floats = load_as(
        "a.e57", scan("\"Float\"", {doubles({1, 0}), doubles({0, 0.5}), doubles({0, 0})}, ""));
    EXPECT_EQ(floats.cloud.colors[point_of_row(floats.cloud, 1)], (Rgb16{0, 32768, 0}));
}

TEST(E57, DropsWhatDidNotComeBack) {
    TestScan scan{4,
                  kXyz + field("cartesianInvalidState", "\"Integer\" minimum=\"0\" maximum=\"2\""),
                  {doubles({1, 2, 0, 4}), doubles({1, 2, 0, 4}), doubles({1, 2, 0, 4}),
                   packed({0, 2, 0, 1}, 2)},
                  ""};
    const LoadResult result = load_as("a.e57", make_e57({scan}));
    EXPECT_EQ(result.cloud.size(), 1U);
    EXPECT_EQ(result.report.num_left_out, 3U);
    EXPECT_EQ(result.cloud.dropped[1].reason, DropReason::kNoReturn);
    EXPECT_TRUE(has_note(result, "3 points without a return"));
    EXPECT_TRUE(result.cloud.channels.empty());
}

TEST(E57, ScansWithRowsAndColumnsAreSeenFromTheOrigin) {
    TestScan scan = two_points();
    for (const char* name : {"rowIndex", "columnIndex"}) {
        scan.fields += field(name, "\"Integer\" minimum=\"0\" maximum=\"1\"");
        scan.streams.push_back(packed({0, 1}, 1));
    }
    const LoadResult result = load_as("a.e57", make_e57({scan}));
    EXPECT_NEAR(result.cloud.sensors[point_of_row(result.cloud, 0)].x, -1 / std::sqrt(14.0), 1e-6);
    EXPECT_TRUE(result.cloud.channels.empty());
}

TEST(E57, TellsItsCoordinateSystem) {
    const auto frame = [&](const std::string& text) {
        const LoadResult result =
            load_as("a.e57", make_e57({two_points()}, "<coordinateMetadata type=\"String\">" +
                                                          text + "</coordinateMetadata>"));
        EXPECT_EQ(has_note(result, "not understood"), text == "nowhere");
        return result.cloud.frame;
    };
    EXPECT_EQ(frame("EPSG:25832").crs.name, "ETRS89 / UTM zone 32N");
    EXPECT_EQ(frame("LOCAL_CS[\"Site\",UNIT[\"foot\",0.3048]]").metres_per_unit, 0.3048);
    EXPECT_EQ(frame("nowhere").crs.name, "");
    EXPECT_EQ(frame("").up, UpAxis::kZ);
}

TEST(E57, FilesThatLieAreErrors) {
    const ErrorCode code = ErrorCode::kInvalidInput;
    const std::string good = make_e57({two_points()});
    const std::string zeros(800, '\0');
    std::string bytes = make_e57({{100, kXyz, {zeros, zeros, zeros}, ""}});
    bytes[1030] = static_cast<char>(bytes[1030] ^ 1);
    expect_load_error("a.e57", bytes, code, "page 1 (byte 1024) does not match its checksum");
    bytes = good;
    bytes[100] = static_cast<char>(bytes[100] ^ 1);
    expect_load_error("a.e57", bytes, code, "page 0 (byte 0) does not match its checksum");
    expect_load_error("a.e57", good.substr(0, good.size() - 1), code, "it is cut off");
    expect_load_error("a.e57", good.substr(0, 40), code, "the header is cut off at byte 40");
    for (const std::uint64_t n : {3ULL, 1ULL << 31}) {
        TestScan scan = two_points();
        scan.num_points = n;
        expect_load_error("a.e57", make_e57({scan}), code, "but bytes are there for only 2");
    }
    TestScan huge = two_points();
    huge.num_points = 1ULL << 60;
    expect_load_error("a.e57", make_e57({huge}), ErrorCode::kLimit, "at most");
    TestScan flat = two_points();
    flat.num_points = 1ULL << 30;
    flat.streams = {"", "", ""};
    flat.fields.clear();
    for (const char* name : {"cartesianX", "cartesianY", "cartesianZ"})
        flat.fields += field(name, "\"Integer\" minimum=\"1\" maximum=\"1\"");
    expect_load_error("a.e57", make_e57({flat}), code, "for only 262144");
    TestScan other = two_points();
    other.fields = field("cartesianX", "\"Float\"");
    expect_load_error("a.e57", make_e57({other}), code, "scan 1 has no coordinates");
    other = two_points();
    other.streams.pop_back();
    expect_load_error("a.e57", make_e57({other}), code, "does not hold the 3 streams");
    other = two_points();
    other.fields += "<";
    expect_load_error("a.e57", make_e57({other}), code, "the XML is damaged");
    expect_load_error("a.e57", make_e57({}), ErrorCode::kEmpty, "0 points");
}

TEST(E57, EveryCutAndFlipIsAnErrorOrACloud) {
    TestScan scan = two_points();
    scan.fields +=
        field("intensity", "\"ScaledInteger\" minimum=\"0\" maximum=\"9\" scale=\"0.1\"");
    scan.streams.push_back(packed({3, 9}, 4));
    const std::string whole = make_e57({scan});
    std::string content;
    for (std::size_t at = 0; at < whole.size(); at += kPage) content += whole.substr(at, kInPage);
    const TempFolder folder;
    const auto try_to_read = [&](const std::string& bytes) {
        try {
            EXPECT_LE(load_cloud(folder.write("a.e57", bytes)).report.num_rows, 1U << 20);
        } catch (const Error& error) {
            EXPECT_FALSE(std::string(error.what()).empty());
        }
    };
    for (std::size_t i = 0; i < content.size(); ++i) {
        if (i % 16 == 0) try_to_read(whole.substr(0, i));
        for (const int flip : {1, 128}) {  // with checksums that are right again
            std::string bytes = content;
            bytes[i] = static_cast<char>(bytes[i] ^ flip);
            try_to_read(as_pages(bytes));
        }
    }
}

}  // namespace
}  // namespace pointbake::test
