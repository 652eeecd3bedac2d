// PLY: the dialects of one and the same cloud.
#include <cmath>

#include "core/hash.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

TEST(Ply, ReadsEveryTypeNameInEveryFormat) {
    for (const char* format : kFormats)
        for (const char* type :
             {"char", "int8", "uchar", "uint8", "short", "int16", "ushort", "uint16", "int",
              "int32", "uint", "uint32", "float", "float32", "double", "float64"}) {
            SCOPED_TRACE(std::string(format) + " " + type);
            const double large = std::string(type).find("8") != std::string::npos ||
                                         std::string(type).find("char") != std::string::npos
                                     ? 100
                                     : 30000;
            const TestElement vertex{
                "vertex",
                {column("uchar", "pad", {1, 2, 3}), column(type, "z", {0, 7, large}),
                 column(type, "x", {3, 4, 5}), column(type, "y", {9, 8, 7})}};
            const PointCloud cloud = load_bytes(make_ply(format, {vertex})).cloud;
            ASSERT_EQ(cloud.size(), 3U);
            EXPECT_EQ(cloud.positions[point_of_row(cloud, 1)], (Vec3d{4, 8, 7}));
            EXPECT_EQ(cloud.positions[point_of_row(cloud, 2)], (Vec3d{5, 7, large}));
        }
}

TEST(Ply, ReadsSignsAndExtremesOfIntegers) {
    for (const char* format : kFormats) {
        const TestElement vertex = three_points(
            {column("int", "i", {-2147483648.0, -1, 2147483647.0}),
             column("uint", "u", {0, 4294967295.0, 1}), column("short", "s", {-32768, -1, 5})});
        const PointCloud cloud = load_bytes(make_ply(format, {vertex})).cloud;
        const auto value = [&](const char* name, std::uint64_t row) {
            return find_channel(cloud, name)->data[point_of_row(cloud, row)];
        };
        EXPECT_EQ(value("i", 0), -2147483648.0F);
        EXPECT_EQ(value("u", 1), 4294967296.0F);  // as a float
        EXPECT_EQ(value("s", 0), -32768.0F);
        EXPECT_EQ(value("s", 1), -1.0F);
    }
}

TEST(Ply, KeepsDoubleCoordinatesExactly) {
    for (const char* format : kFormats) {
        TestElement vertex{"vertex",
                           {column("double", "x", {665187.522077, 0.1}),
                            column("double", "y", {5648349.895035, -1e-300}),
                            column("double", "z", {241.767693, 1e300})}};
        const PointCloud cloud = load_bytes(make_ply(format, {vertex})).cloud;
        EXPECT_EQ(cloud.positions[point_of_row(cloud, 0)],
                  (Vec3d{665187.522077, 5648349.895035, 241.767693}));
        EXPECT_EQ(cloud.positions[point_of_row(cloud, 1)], (Vec3d{0.1, -1e-300, 1e300}));
    }
}

TEST(Ply, SkipsElementsAndListsAround) {
    for (const char* format : kFormats) {
        TestElement before{"camera",
                           {column("double", "focal", {1, 2}),
                            {"float", "distortion", {{}, {1, 2, 3}}, "uchar"},
                            column("char", "kind", {1, 2})}};
        TestElement vertex = three_points({{"short", "seen_by", {{5}, {}, {6, 7, 8, 9}}, "ushort"},
                                           column("uchar", "quality", {10, 20, 30})});
        TestElement after{"edge", {column("int", "a", {0}), column("int", "b", {1})}};
        const LoadResult result = load_bytes(make_ply(format, {before, vertex, after}));
        const PointCloud& cloud = result.cloud;
        ASSERT_EQ(cloud.size(), 3U);
        EXPECT_EQ(cloud.positions[point_of_row(cloud, 2)], (Vec3d{0, 2, 0}));
        EXPECT_EQ(find_channel(cloud, "quality")->data[point_of_row(cloud, 2)], 30.0F);
        EXPECT_FALSE(result.mesh.has_value());
        EXPECT_EQ(result.report.notes.size(), 2U);  // the list, the elements
    }
}

TEST(Ply, ReadsTextWithAnyLineEndAndComments) {
    const std::string text =
        "ply\nformat ascii 1.0\ncomment made by hand\nobj_info x 1\n\telement  vertex\t3 \n"
        "property float x\nproperty   float y\nproperty float z\nend_header\n"
        "comment in the body\n\n0 0 0\n  1\t0  0 \n+0 2e0 .0";
    for (const char* line_end : {"\n", "\r\n", "\r"}) {
        std::string bytes;
        for (char c : text) bytes += c == '\n' ? line_end : std::string(1, c);
        for (const char* end : {"", line_end}) {
            const PointCloud cloud = load_bytes(bytes + end).cloud;
            ASSERT_EQ(cloud.size(), 3U);
            EXPECT_EQ(cloud.positions[point_of_row(cloud, 2)], (Vec3d{0, 2, 0}));
        }
    }
}

TEST(Ply, TakesTheLineEndOfTheHeaderFromItsOtherLines) {
    // x = 0x0a.. begins with a line feed: it is data, unless the header's lines end in CR LF.
    const std::string header =
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\n"
        "property float y\nproperty float z\nend_header\n";
    const float x = 6.0F + 0x1.4p-18F * 2.0F;
    std::string data;
    for (float v : {x, 2.0F, 3.0F}) append_value(data, "float", "binary_little_endian", v);
    data[0] = '\n';
    const double expected = [&] {
        float v;
        std::memcpy(&v, data.data(), 4);
        return static_cast<double>(v);
    }();
    for (const char* line_end : {"\n", "\r\n", "\r"}) {
        std::string bytes;
        for (char c : header) bytes += c == '\n' ? line_end : std::string(1, c);
        EXPECT_EQ(load_bytes(bytes + data).cloud.positions[0], (Vec3d{expected, 2, 3}));
    }
    // only the last line ends in CR LF
    const std::string mixed = header.substr(0, header.size() - 1) + "\r\n";
    EXPECT_EQ(load_bytes(mixed + data).cloud.positions[0], (Vec3d{expected, 2, 3}));
}

TEST(Ply, ReadsNotFiniteWordsOfEveryKind) {
    const std::string bytes =
        "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\n"
        "property float z\nend_header\nnan 0 0\n-nan 0 0\ninf 0 0\n+inf 0 0\n-Infinity 0 0\n"
        "1.#QNAN 0 0\n-1.#IND 0 0\n1e999 0 0\n1e-999 1 1\n";
    const LoadResult result = load_bytes(bytes);
    EXPECT_EQ(result.report.num_non_finite, 8U);
    ASSERT_EQ(result.cloud.size(), 1U);
    EXPECT_EQ(result.cloud.positions[0], (Vec3d{0, 1, 1}));
    ASSERT_EQ(result.cloud.dropped.size(), 8U);
    EXPECT_EQ(result.cloud.dropped[7].row, 7U);
    EXPECT_EQ(result.cloud.dropped[7].reason, DropReason::kNonFinite);
}

TestElement random_points(std::size_t n) {
    TestElement e{"vertex", {}};
    std::uint64_t seed = 0;
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "value"}) {
        std::vector<double> values;
        for (std::size_t i = 0; i < n; ++i)
            values.push_back(static_cast<double>(static_cast<float>(random_unit(seed, i) - 0.5)));
        e.properties.push_back(column("float", name, values));
        ++seed;
    }
    return e;
}

TEST(Ply, FormatsAgreeAcrossChunks) {
    const TestElement points = random_points(9001);  // text: several chunks, binary: blocks
    const PointCloud expected = load_bytes(make_ply("binary_little_endian", {points})).cloud;
    ASSERT_EQ(expected.size(), 9001U);
    for (const char* format : {"ascii", "binary_big_endian"}) {
        const PointCloud cloud = load_bytes(make_ply(format, {points})).cloud;
        EXPECT_EQ(cloud.positions, expected.positions) << format;
        EXPECT_EQ(cloud.normals, expected.normals) << format;
        EXPECT_EQ(cloud.rows, expected.rows) << format;
        EXPECT_EQ(cloud.channels[0].data, expected.channels[0].data) << format;
    }
}

TEST(Ply, SameForOneAndSevenThreads) {
    const TestElement points = random_points(9001);
    for (const char* format : kFormats) {
        const std::string bytes = make_ply(format, {points});
        Context one, seven;
        one.threads = 1;
        seven.threads = 7;
        const PointCloud a = load_bytes(bytes, one).cloud;
        const PointCloud b = load_bytes(bytes, seven).cloud;
        EXPECT_EQ(a.positions, b.positions);
        EXPECT_EQ(a.normals, b.normals);
        EXPECT_EQ(a.rows, b.rows);
    }
}

TEST(Ply, StopsWhenCancelled) {
    std::stop_source source;
    Context context;
    context.stop = source.get_token();
    // from the first progress call on
    context.progress = [&](std::string_view, double) { source.request_stop(); };
    const std::string bytes = make_ply("ascii", {random_points(100)});
    EXPECT_EQ(error_of([&] { load_bytes(bytes, context); }).code(), ErrorCode::kCancelled);
}

TEST(Ply, ProgressIsMonotone) {
    double last = -1.0;
    Context context;
    context.progress = [&](std::string_view stage, double fraction) {
        EXPECT_EQ(stage, "load");
        EXPECT_GE(fraction, last);
        last = fraction;
    };
    load_bytes(make_ply("ascii", {three_points()}), context);
    EXPECT_EQ(last, 1.0);
}

}  // namespace
}  // namespace pointbake::test
