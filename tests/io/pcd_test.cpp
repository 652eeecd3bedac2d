// PCD: all three kinds of data, all types, colours, sensors; and files that lie.
#include <bit>

#include "core/color.h"
#include "io/lzf.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

struct Field {
    std::string name;
    char kind = 'F';
    int size = 4;
    std::vector<std::vector<double>> values;  ///< per point
};

std::string raw_value(const Field& field, double value) {
    const auto bytes = [](auto typed) {
        return std::string(reinterpret_cast<const char*>(&typed), sizeof typed);
    };
    if (field.kind == 'F') return field.size == 8 ? bytes(value) : bytes(static_cast<float>(value));
    const auto whole = static_cast<std::int64_t>(value);
    return bytes(whole).substr(0, static_cast<std::size_t>(field.size));
}

/// Literal runs, and repetitions of the last 8 bytes where there are such.
std::string packed_lzf(const std::string& raw) {
    std::string out;
    for (std::size_t at = 0; at < raw.size();) {
        std::size_t length = 0;
        while (at >= 8 && at + length < raw.size() && length < 264 &&
               raw[at + length] == raw[at + length - 8])
            ++length;
        if (length >= 9) {
            out += static_cast<char>(7 << 5);
            out += static_cast<char>(length - 9);
            out += static_cast<char>(7);
            at += length;
        } else if (length >= 3) {
            out += static_cast<char>((length - 2) << 5);
            out += static_cast<char>(7);
            at += length;
        } else {
            out += '\0';
            out += raw[at++];
        }
    }
    return out;
}

std::string size_32(std::size_t size) {
    const auto n = static_cast<std::uint32_t>(size);
    return {reinterpret_cast<const char*>(&n), 4};
}

std::string header_of(const std::vector<Field>& fields, const std::string& data,
                      const std::string& more = "") {
    std::string names, sizes, kinds, counts;
    for (const Field& f : fields) {
        names += " " + f.name;
        sizes += " " + std::to_string(f.size);
        kinds += std::string(" ") + f.kind;
        counts += " " + std::to_string(f.values[0].size());
    }
    const std::string n = std::to_string(fields[0].values.size());
    return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS" + names + "\nSIZE" +
           sizes + "\nTYPE" + kinds + "\nCOUNT" + counts + "\nWIDTH " + n + "\nHEIGHT 1\n" + more +
           "POINTS " + n + "\nDATA " + data + "\n";
}

std::string make_pcd(const std::vector<Field>& fields, const std::string& data,
                     const std::string& more = "") {
    const std::size_t n = fields[0].values.size();
    std::string body, columns;
    for (std::size_t i = 0; i < n; ++i) {
        for (const Field& f : fields)
            for (const double v : f.values[i]) {
                char text[40];
                std::snprintf(text, sizeof text, "%.17g ", v);
                body += data == "ascii" ? std::string(text) : raw_value(f, v);
            }
        if (data == "ascii") body += "\n";
    }
    if (data == "binary_compressed") {
        for (const Field& f : fields)
            for (const std::vector<double>& values : f.values)
                for (const double v : values) columns += raw_value(f, v);
        const std::string packed = packed_lzf(columns);
        body = size_32(packed.size()) + size_32(columns.size()) + packed;
    }
    return header_of(fields, data, more) + body;
}

Field column_of(std::string name, char kind, int size, const std::vector<double>& values) {
    Field f{std::move(name), kind, size, {}};
    for (const double v : values) f.values.push_back({v});
    return f;
}

std::vector<Field> three(std::vector<Field> more = {}) {
    std::vector<Field> fields = {column_of("x", 'F', 4, {0, 1, 0}),
                                 column_of("y", 'F', 4, {0, 0, 2}),
                                 column_of("z", 'F', 4, {0, 0, 0})};
    for (Field& f : more) fields.push_back(std::move(f));
    return fields;
}

const char* const kData[] = {"ascii", "binary", "binary_compressed"};

void expect_error(const std::string& bytes, ErrorCode code, const std::string& part) {
    expect_load_error("cloud.ply", bytes, code, part);
}

TEST(Pcd, ReadsEveryTypeInEveryKindOfData) {
    for (const char* data : kData) {
        SCOPED_TRACE(data);
        const LoadResult result = load_bytes(make_pcd(
            {column_of("X", 'F', 8, {0.1, 1e7 + 0.125, -3}), column_of("Y", 'I', 2, {-300, 2, 5}),
             column_of("Z", 'U', 4, {4e9, 0, 1}), column_of("intensity", 'U', 1, {0, 255, 7}),
             column_of("label", 'I', 8, {-1, 5, 6}), column_of("t", 'U', 8, {1, 2, 3}),
             column_of("i1", 'I', 1, {-128, 0, 127}), column_of("u2", 'U', 2, {65535, 0, 1}),
             column_of("i4", 'I', 4, {-70000, 0, 1})},
            data));
        const PointCloud& cloud = result.cloud;
        EXPECT_EQ(result.report.format, "PCD " + std::string(data));
        ASSERT_EQ(cloud.size(), 3U);
        const std::size_t first = point_of_row(cloud, 0);
        EXPECT_EQ(cloud.positions[first], (Vec3d{0.1, -300, 4e9}));
        EXPECT_EQ(cloud.positions[point_of_row(cloud, 1)], (Vec3d{1e7 + 0.125, 2, 0}));
        EXPECT_EQ(find_channel(cloud, "label")->kind, ChannelKind::kCategory);
        EXPECT_EQ(find_channel(cloud, "label")->data[first], -1.0F);
        EXPECT_EQ(find_channel(cloud, "i1")->data[first], -128.0F);
        EXPECT_EQ(find_channel(cloud, "u2")->data[first], 65535.0F);
        EXPECT_EQ(find_channel(cloud, "i4")->data[first], -70000.0F);
        EXPECT_TRUE(cloud.sensors.empty());
    }
}

TEST(Pcd, ReadsColorsPackedInFloatsAndIntegers) {
    const std::uint32_t packed = 10U << 16 | 200U << 8 | 255U;
    for (const char* data : kData)
        for (const char* name : {"rgb", "rgba"}) {
            SCOPED_TRACE(std::string(data) + " " + name);
            const auto bits = static_cast<double>(std::bit_cast<float>(packed));
            for (const Field& color :
                 {column_of(name, 'F', 4, {bits, 0, 0}),
                  column_of(name, 'U', 4, {static_cast<double>(packed), 0, 0}),
                  column_of(name, 'I', 4, {static_cast<double>(packed), 0, 0})}) {
                const PointCloud cloud = load_bytes(make_pcd(three({color}), data)).cloud;
                ASSERT_EQ(cloud.colors.size(), 3U);
                EXPECT_EQ(cloud.colors[point_of_row(cloud, 0)], rgb16_from_8bit(10, 200, 255));
                EXPECT_EQ(cloud.colors[point_of_row(cloud, 1)], rgb16_from_8bit(0, 0, 0));
                EXPECT_EQ(find_channel(cloud, "alpha") != nullptr, std::string(name) == "rgba");
            }
        }
    // The alpha byte makes the float negative; as an integer, too.
    const PointCloud cloud =
        load_bytes(make_pcd(three({column_of("rgb", 'I', 4, {-16776961, 0, 0})}), "ascii")).cloud;
    EXPECT_EQ(cloud.colors[point_of_row(cloud, 0)], rgb16_from_8bit(0, 0, 255));
}

TEST(Pcd, ReadsNormalsPaddingAndVectors) {
    for (const char* data : kData) {
        SCOPED_TRACE(data);
        const LoadResult result = load_bytes(make_pcd(
            three({column_of("normal_x", 'F', 4, {0, 0, 3}), column_of("_", 'U', 1, {1, 2, 3}),
                   column_of("normal_y", 'F', 4, {0, 2, 0}),
                   column_of("normal_z", 'F', 4, {1, 0, 4}),
                   Field{"pair", 'F', 4, {{1, 2}, {3, 4}, {5, 6}}},
                   Field{"huge", 'U', 1, std::vector(3, std::vector<double>(65, 1.0))}}),
            data));
        const PointCloud& cloud = result.cloud;
        ASSERT_EQ(cloud.normals.size(), 3U);
        EXPECT_EQ(cloud.normals[point_of_row(cloud, 1)], (Vec3f{0, 1, 0}));
        EXPECT_FLOAT_EQ(cloud.normals[point_of_row(cloud, 2)].z, 0.8F);
        EXPECT_EQ(cloud.channels.size(), 2U);
        EXPECT_EQ(find_channel(cloud, "pair_1")->data[point_of_row(cloud, 2)], 6.0F);
        EXPECT_NE(std::find(result.report.notes.begin(), result.report.notes.end(),
                            "field 'huge' ignored: 65 values per point"),
                  result.report.notes.end());
    }
}

TEST(Pcd, TheViewpointIsTheSensor) {
    for (const char* data : kData) {
        const LoadResult result = load_bytes(make_pcd(three(), data, "VIEWPOINT 0 0 5 1 0 0 0\n"));
        EXPECT_EQ(result.report.scanners, (std::vector<Vec3d>{{0, 0, 5}}));
        const PointCloud& cloud = result.cloud;
        ASSERT_EQ(cloud.sensors.size(), 3U);
        EXPECT_EQ(cloud.sensors[point_of_row(cloud, 0)], (Vec3f{0, 0, 1}));
        EXPECT_TRUE(
            load_bytes(make_pcd(three(), data, "VIEWPOINT 0 0 0 1 0 0 0\n")).cloud.sensors.empty());
    }
}

TEST(Pcd, OrganisedCloudsLoseTheirHolesAndSeeFromTheOrigin) {
    std::string bytes = make_pcd(
        {column_of("x", 'F', 4, {1, NAN, 2, NAN}), column_of("y", 'F', 4, {0, NAN, 0, NAN}),
         column_of("z", 'F', 4, {4, NAN, 4, NAN})},
        "binary");
    bytes.replace(bytes.find("WIDTH 4\nHEIGHT 1"), 16, "WIDTH 2\nHEIGHT 2");
    const LoadResult result = load_bytes(bytes);
    EXPECT_EQ(result.report.num_rows, 4U);
    EXPECT_EQ(result.report.num_non_finite, 2U);
    ASSERT_EQ(result.cloud.sensors.size(), 2U);
    EXPECT_LT(result.cloud.sensors[0].z, 0.0F);
}

TEST(Pcd, ReadsOldAndBareHeaders) {
    EXPECT_EQ(
        load_bytes("VERSION .5\nCOLUMNS x y z\nWIDTH 2\nDATA ascii\n0 0 0\n1 1 1\n").cloud.size(),
        2U);
    EXPECT_EQ(load_bytes("# made by hand\r\nFIELDS x y z\r\nPOINTS 2\r\nDATA ascii\r\n0 0 0\r\n"
                         "1,2,3\r\n")
                  .cloud.size(),
              2U);
    const LoadResult more = load_bytes("FIELDS x y z\nPOINTS 2\nDATA ascii\n0 0 0\n1 2 3\n4 5 6\n");
    EXPECT_EQ(more.report.num_rows, 2U);
}

TEST(Pcd, LoneNumbersAreBadRows) {
    const std::string head =
        "VERSION\t0.7\nFIELDS\tx\ty\tz\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\n"
        "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n";
    for (const char* mark : {"", "\xef\xbb\xbf"}) {
        const LoadResult result = load_as("a.pcd", mark + head + "1 2 3.5\n7\n4 5 6\n");
        EXPECT_EQ(result.report.format, "PCD ascii");
        EXPECT_EQ(result.report.num_rows, 3U);
        EXPECT_EQ(result.report.num_left_out, 1U);
    }
}

TEST(Pcd, BadTextRowsAreDroppedUnlessTheyAreTheMost) {
    const std::string head = "FIELDS x y z\nPOINTS 5\nDATA ascii\n";
    const LoadResult result = load_bytes(head + "0 0 0\n1 1 1\nspam 1 2\n2 2 2\n3 3\n");
    EXPECT_EQ(result.report.num_left_out, 2U);
    EXPECT_EQ(result.report.num_kept, 3U);
    ASSERT_EQ(result.cloud.dropped.size(), 2U);
    EXPECT_EQ(result.cloud.dropped[0].row, 2U);
    EXPECT_EQ(result.cloud.dropped[0].reason, DropReason::kUnreadable);
    EXPECT_NE(result.report.notes[0].find("2 rows not of 3 numbers: dropped (the first at"),
              std::string::npos);
    EXPECT_NE(result.report.notes[0].find("cloud.ply:6: text that is no number"),
              std::string::npos);
    expect_error(head + "0 0 0\na b c\na b c\na b c\n1 1 1\n", ErrorCode::kInvalidInput,
                 "cloud.ply:5: text that is no number; 3 of 5 rows");
}

TEST(Pcd, HeadersThatCannotBeAreNamed) {
    const ErrorCode code = ErrorCode::kInvalidInput;
    expect_error("VERSION .7\n", code, "no 'DATA' line");
    expect_error("VERSION .7\nDATA ascii\n", code, "no 'FIELDS' line");
    expect_error("FIELDS x y z\nDATA octal\n", code, ":2: 'DATA' wants ascii, binary");
    expect_error("FIELDS x y z\nSIZE 4 4\nDATA ascii\n", code, "3 FIELDS, but 2 values of SIZE");
    expect_error("FIELDS x y z\nSIZE 4 4 3\nDATA ascii\n", code,
                 "field 'z' has the type F and the size 3");
    expect_error("FIELDS x y z\nTYPE F F Q\nDATA ascii\n", code, "field 'z' has the type Q");
    expect_error("FIELDS x y z\nWIDTH -1\nDATA ascii\n", code, ":2: 'WIDTH' wants whole numbers");
    expect_error("FIELDS x y z\nPOINTS 99999999999999999999999\nDATA ascii\n", code,
                 ":2: 'POINTS' wants whole numbers");
    expect_error("FIELDS x y z\nVIEWPOINT 1 2\nDATA ascii\n", code, ":2: 'VIEWPOINT' wants");
    expect_error("FIELDS x y z\nPIONTS 3\nDATA ascii\n", code, ":2: 'PIONTS' is no line");
    expect_error("FIELDS x y\nPOINTS 3\nDATA ascii\n", code, "the header has no field 'z'");
    expect_error("FIELDS x y z\nPOINTS 0\nDATA ascii\n", ErrorCode::kEmpty, "0 points");
}

TEST(Pcd, CountsThatLieFailAtOnce) {
    for (const char* data : kData)
        for (const char* count : {"4", "4294967295", "18446744073709551615"}) {
            std::string bytes = make_pcd(three(), data);
            bytes.replace(bytes.find("POINTS 3"), 8, "POINTS " + std::string(count));
            expect_error(
                bytes, ErrorCode::kInvalidInput,
                "promises " + std::string(count) + " points, but bytes are there for only 3");
        }
    for (const char* data : kData) {
        std::string bytes = make_pcd(three({column_of("f", 'F', 8, {0, 0, 0})}), data);
        bytes.replace(bytes.find("COUNT 1 1 1 1"), 13, "COUNT 1 1 1 4294967295");
        expect_error(bytes, ErrorCode::kInvalidInput, "bytes are there for only 0");
    }
    std::string bytes = make_pcd(three(), "binary_compressed");
    const std::size_t sizes = bytes.find("binary_compressed\n") + 18;
    std::string huge = bytes;
    huge.replace(sizes + 4, 4, "\xff\xff\xff\xff");
    expect_error(huge, ErrorCode::kInvalidInput, "bytes cannot unpack to 4294967295");
    huge = bytes;
    huge.replace(sizes, 4, "\xff\xff\xff\x7f");
    expect_error(huge, ErrorCode::kInvalidInput, "2147483647 compressed bytes are promised");
}

TEST(Pcd, EveryCutFailsOrReadsWhole) {
    for (const char* data : kData) {
        const std::string whole = make_pcd(three(), data);
        for (std::size_t size = 0; size < whole.size(); ++size) {
            try {
                EXPECT_EQ(load_bytes(whole.substr(0, size)).report.num_rows, 3U);
                EXPECT_STREQ(data, "ascii");
            } catch (const Error& error) {
                EXPECT_FALSE(std::string(error.what()).empty());
            }
        }
    }
}

TEST(Pcd, EveryFlippedByteIsAnErrorOrACloud) {
    const TempFolder folder;
    for (const char* data : kData) {
        const std::string whole =
            make_pcd(three({column_of("rgb", 'F', 4, {0, 1e-39, 2e-39})}), data);
        for (std::size_t i = 0; i < whole.size(); ++i)
            for (int flip : {0x01, 0xff}) {
                std::string bytes = whole;
                bytes[i] = static_cast<char>(bytes[i] ^ flip);
                try {
                    EXPECT_LE(load_cloud(folder.write("a.pcd", bytes)).cloud.size(), 3U);
                } catch (const Error&) {
                }
            }
    }
}

TEST(Pcd, ManyRowsAreTheSameForAnyNumberOfThreads) {
    Field x = column_of("x", 'F', 4, {}), y = column_of("y", 'F', 4, {}),
          z = column_of("z", 'F', 4, {});
    for (int i = 0; i < 60000; ++i) {
        x.values.push_back({std::sin(i * 0.1)});
        y.values.push_back({std::cos(i * 0.37)});
        z.values.push_back({i * 1e-4});
    }
    std::vector<std::vector<Vec3d>> clouds;
    for (const char* data : kData)
        for (int threads : {1, 4})
            clouds.push_back(
                load_bytes(make_pcd({x, y, z}, data), {.threads = threads}).cloud.positions);
    // Text has more digits than the floats of the others.
    EXPECT_EQ(clouds[0], clouds[1]);
    for (std::size_t i = 3; i < clouds.size(); ++i) EXPECT_EQ(clouds[2], clouds[i]);
}

std::span<const std::byte> bytes_of(const std::string& text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

TEST(Lzf, UnpacksRunsAndRepetitions) {
    std::string out(9, '?');
    // "abc", then 6 bytes from 3 back
    ASSERT_TRUE(unpack_lzf(bytes_of(std::string("\x02"
                                                "abc\x80\x02",
                                                6)),
                           std::as_writable_bytes(std::span(out.data(), out.size()))));
    EXPECT_EQ(out, "abcabcabc");
    out.assign(1 + 264, '?');
    ASSERT_TRUE(unpack_lzf(bytes_of(std::string("\x00z\xe0\xff\x00", 5)),
                           std::as_writable_bytes(std::span(out.data(), out.size()))));
    EXPECT_EQ(out, std::string(265, 'z'));
}

TEST(Lzf, RandomBytesNeverLeaveTheirBounds) {
    std::uint32_t seed = 7;
    const auto random = [&] { return (seed = seed * 1664525U + 1013904223U) >> 16; };
    for (int i = 0; i < 20000; ++i) {
        std::string in(random() % 40, '\0');
        for (char& c : in) c = static_cast<char>(random());
        std::vector<std::byte> out(random() % 300);
        unpack_lzf(bytes_of(in), out);  // under the address sanitizer, this is the test
    }
}

}  // namespace
}  // namespace pointbake::test
