// Tables of text: separators, headers, what columns are taken for, and what is no table.
#include <bit>
#include <charconv>

#include "core/color.h"
#include "io/test_files.h"
#include "io/text_layout.h"

namespace pointbake::test {
namespace {

const std::vector<Vec3d> kPoints = {{0, 0.5, 1}, {1e6 + 0.25, -2, 3e-5}, {4, 5, 6}};

void expect_points(const PointCloud& cloud) {
    ASSERT_EQ(cloud.size(), kPoints.size());
    for (std::size_t i = 0; i < kPoints.size(); ++i)
        EXPECT_EQ(cloud.positions[point_of_row(cloud, i)], kPoints[i]);
}

/// Lines with the values in columns, `separator` between them.
std::string table(const std::vector<std::vector<double>>& rows, const std::string& separator = " ",
                  const std::string& line_end = "\n") {
    std::string out;
    for (const std::vector<double>& row : rows) {
        for (std::size_t k = 0; k < row.size(); ++k) {
            char text[40];
            std::snprintf(text, sizeof text, "%.10g", row[k]);
            out += (k == 0 ? "" : separator) + text;
        }
        out += line_end;
    }
    return out;
}

/// Row i has three coordinates that are not whole, then more(i).
template <class More>
std::string many_rows(std::size_t n, More&& more) {
    std::vector<std::vector<double>> rows;
    for (std::size_t i = 0; i < n; ++i) {
        const double t = static_cast<double>(i);
        std::vector<double> row = {t + 0.5, t * 0.25, -t};
        for (double v : more(i)) row.push_back(v);
        rows.push_back(row);
    }
    return table(rows);
}

TEST(Text, ReadsEverySeparatorAndLineEnd) {
    for (const char* separator : {" ", "\t", ",", ";", ", ", " ; ", "   ", " \t "})
        for (const char* line_end : {"\n", "\r\n", "\r", "\n\n", " \n"}) {
            SCOPED_TRACE(std::string("'") + separator + "'");
            std::vector<std::vector<double>> rows;
            for (const Vec3d& p : kPoints) rows.push_back({p.x, p.y, p.z});
            const std::string body = table(rows, separator, line_end);
            expect_points(load_as("a.xyz", body).cloud);
            expect_points(load_as("a", "\xef\xbb\xbf" + body).cloud);  // with a byte order mark
            expect_points(load_as("a.csv", body.substr(0, body.find_last_of("56") + 2)).cloud);
        }
}

TEST(Text, ReadsHeadersAndComments) {
    const std::string body = "0,0.5,1,10\n1000000.25,-2,3e-5,20\n4,5,6,30\n";
    for (const char* head :
         {"x,y,z,intensity\n", "X, Y, Z, Intensity\n", "\"X\",\"Y\",\"Z\",\"Intensity\"\r\n",
          "// X Y Z Intensity\n", "# x y z intensity\n", "#made today\n\n// x,y,z,intensity\n",
          "Easting;Northing;Elevation;Intensity\n", "x [m],y [m],z [m],intensity\n"}) {
        SCOPED_TRACE(head);
        const LoadResult result = load_as("a.txt", head + body);
        expect_points(result.cloud);
        ASSERT_EQ(result.cloud.channels.size(), 1U);
        EXPECT_EQ(result.cloud.channels[0].data[point_of_row(result.cloud, 1)], 20.0F);
        EXPECT_TRUE(has_note(result, "by the header line")) << result.report.notes[0];
    }
    expect_points(
        load_as("a.txt", "2 points\n# between\n0 0.5 1\n// x\n\n1000000.25 -2 3e-5\n4 5 6\n")
            .cloud);
}

TEST(Text, HeadersMayNameAnyOrder) {
    const PointCloud cloud = load_as("a.csv",
                                     "label,B,G,R,z,y,x,Nx,Ny,Nz\n3,30,20,10,1,2,3.5,0,0,1\n"
                                     "4,0,0,255,4,5,6.5,1,0,0\n")
                                 .cloud;
    const std::size_t first = point_of_row(cloud, 0);
    EXPECT_EQ(cloud.positions[first], (Vec3d{3.5, 2, 1}));
    EXPECT_EQ(cloud.colors[first], rgb16_from_8bit(10, 20, 30));
    EXPECT_EQ(cloud.normals[first], (Vec3f{0, 0, 1}));
    EXPECT_EQ(find_channel(cloud, "label")->kind, ChannelKind::kCategory);
}

TEST(Text, TellsColumnsByTheirNumberAndContent) {
    const auto color = [](std::size_t i) {
        return std::vector<double>{static_cast<double>(i % 256), 7, 255};
    };
    const auto normal = [](std::size_t i) {
        const double a = static_cast<double>(i);
        return std::vector<double>{std::sin(a), std::cos(a), 0};
    };
    const auto join = [](std::vector<double> a, const std::vector<double>& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
    };
    const auto columns = [&](const std::string& name, auto&& more) {
        const LoadResult result = load_as(name, many_rows(300, more));
        const std::string& note = result.report.notes.back();
        return note.substr(12, note.find(", by what") - 12);
    };
    using V = std::vector<double>;
    EXPECT_EQ(columns("a.xyz", [](std::size_t) { return V{}; }), "x,y,z");
    EXPECT_EQ(columns("a.xyz", [](std::size_t i) { return V{double(i)}; }), "x,y,z,intensity");
    EXPECT_EQ(columns("a.xyz", color), "x,y,z,red,green,blue");
    EXPECT_EQ(columns("a.xyz", normal), "x,y,z,nx,ny,nz");
    EXPECT_EQ(columns("a.xyz", [](std::size_t i) { return V{0.001 * double(i), 0.5, 1}; }),
              "x,y,z,red,green,blue");
    EXPECT_EQ(columns("a.xyz", [](std::size_t i) { return V{-double(i), 0.5, 1}; }),
              "x,y,z,column_4,column_5,column_6");
    EXPECT_EQ(columns("a.txt", [&](std::size_t i) { return join({-1613}, color(i)); }),
              "x,y,z,intensity,red,green,blue");
    // Both would fit: PTS has the intensity first, others have alpha behind.
    EXPECT_EQ(columns("a.pts", [&](std::size_t i) { return join(color(i), {255}); }),
              "x,y,z,intensity,red,green,blue");
    EXPECT_EQ(columns("a.xyz", [&](std::size_t i) { return join(color(i), {255}); }),
              "x,y,z,red,green,blue,column_7");
    EXPECT_EQ(columns("a.xyz", [&](std::size_t i) { return join(normal(i), {0.7}); }),
              "x,y,z,nx,ny,nz,column_7");
    EXPECT_EQ(columns("a.xyz", [&](std::size_t i) { return join(color(i), normal(i)); }),
              "x,y,z,red,green,blue,nx,ny,nz");
    EXPECT_EQ(columns("a.xyz", [&](std::size_t i) { return join(normal(i), color(i)); }),
              "x,y,z,nx,ny,nz,red,green,blue");
    EXPECT_EQ(
        columns("a.pts", [&](std::size_t i) { return join(join({-5}, color(i)), normal(i)); }),
        "x,y,z,intensity,red,green,blue,nx,ny,nz");
}

TEST(Text, LaterRowsMayShowThatColumnsAreSomethingElse) {
    // Beyond the sample there is a value that no colour has.
    const std::size_t n = 20000;
    const LoadResult result = load_as("a.xyz", many_rows(n, [&](std::size_t i) {
                                          const double last = i + 1 == n ? 256 : 3;
                                          return std::vector<double>{1, 2, last};
                                      }));
    EXPECT_TRUE(result.cloud.colors.empty());
    EXPECT_EQ(result.cloud.channels.size(), 3U);
    EXPECT_EQ(result.cloud.size(), n);
}

TEST(Text, ColorsOfIntegersAndFloatsAreRight) {
    const PointCloud whole = load_as("a.xyz", "0.5 0 0 1 0 255\n1.5 0 0 0 1 1\n").cloud;
    EXPECT_EQ(whole.colors[point_of_row(whole, 0)], rgb16_from_8bit(1, 0, 255));
    // Dark integers are not floats from 0 to 1.
    const PointCloud dark = load_as("a.csv", "x,y,z,r,g,b\n0.5,0,0,1,0,1\n1.5,0,0,0,1,1\n").cloud;
    EXPECT_EQ(dark.colors[point_of_row(dark, 0)], rgb16_from_8bit(1, 0, 1));
    const PointCloud floats =
        load_as("a.txt", "//X Y Z Rf Gf Bf\n0.5 0 0 1.0 0 0.2\n1.5 0 0 0 0.4 1\n").cloud;
    EXPECT_EQ(floats.colors[point_of_row(floats, 0)], rgb16_from_8bit(255, 0, 51));
}

TEST(Text, TheOptionNamesColumns) {
    const std::string body = "7 1 2 3.5 255 0 0 9 x\n7 4 5 6.5 0 255 0 9 y\n";
    const LoadResult result = load_as("a.txt", body, {.columns = "-,z,y,x,red,green,blue,-"});
    const PointCloud& cloud = result.cloud;
    EXPECT_EQ(cloud.positions[point_of_row(cloud, 0)], (Vec3d{3.5, 2, 1}));
    EXPECT_EQ(cloud.colors[point_of_row(cloud, 1)], rgb16_from_8bit(0, 255, 0));
    EXPECT_TRUE(cloud.channels.empty());
    EXPECT_TRUE(has_note(result, "columns are -,z,y,x,red,green,blue,-,-, by --columns"));
    const ErrorCode code = ErrorCode::kInvalidOption;
    expect_load_error("a.txt", body, code, "x, y and z must be", {.columns = "x,y"});
    expect_load_error("a.txt", body, code, "'X' is named twice", {.columns = "x,y,z,X"});
    expect_load_error("a.txt", body, code, "'' is no name", {.columns = "x,y,z,"});
    expect_load_error("a.txt", body, code, "10 are named, but", {.columns = "x,y,z,a,b,c,d,e,f,g"});
    // Words where a coordinate should be
    expect_load_error("a.txt", body, ErrorCode::kInvalidInput, "column 'x' holds no numbers",
                      {.columns = "y,z,-,-,-,-,-,-,x"});
}

TEST(Text, CountsOfPtsAreNoPoints) {
    const LoadResult two = load_as("a.pts",
                                   "2\n0 0.5 1 -7 1 2 3\n1 1 1 8 4 5 6\n"
                                   "1\n2 2 2 9 7 8 9\n");
    EXPECT_EQ(two.report.num_rows, 3U);
    EXPECT_EQ(two.report.num_left_out, 0U);
    EXPECT_FALSE(has_note(two, "promised"));
    EXPECT_EQ(find_channel(two.cloud, "intensity")->data[point_of_row(two.cloud, 0)], -7.0F);
    EXPECT_TRUE(has_note(load_as("a.pts", "5\n0 0.5 1\n1 1 1\n"), "5 points promised, but 2 rows"));
    EXPECT_TRUE(has_note(load_as("a.pts", std::string(400, '9') + "\n0 0.5 1\n1 1 1\n"),
                         "promised, but 2 rows there"));
}

TEST(Text, OldPwnHasItsNormalsBehind) {
    const PointCloud cloud = load_as("a.pwn", "2\n0 0 0.5\n1 1 1\n0 0 2\n0 1 0\n").cloud;
    ASSERT_EQ(cloud.size(), 2U);
    EXPECT_EQ(cloud.normals[point_of_row(cloud, 0)], (Vec3f{0, 0, 1}));
    EXPECT_EQ(cloud.normals[point_of_row(cloud, 1)], (Vec3f{0, 1, 0}));
    EXPECT_EQ(load_as("a.pwn", "0.5 0 0 0 0 1\n1 1 1 0 1 0\n").cloud.normals.size(), 2U);
}

TEST(Text, BadRowsAreDroppedAndCounted) {
    const LoadResult result =
        load_as("a.xyz", "0 0.5 1\n1 1\n2 2 2\nnan 3 3\n4 4 4 4\n5 five 5\n6 6 6\n7 7 7\n8,,8\n");
    EXPECT_EQ(result.report.num_rows, 9U);
    EXPECT_EQ(result.report.num_left_out, 3U);
    EXPECT_EQ(result.report.num_non_finite, 2U);
    EXPECT_EQ(result.report.num_kept, 4U);
    EXPECT_TRUE(has_note(result, "3 rows not of 3 numbers: dropped (the first at"));
    EXPECT_TRUE(has_note(result, "a.xyz:2: too few columns)"));
    EXPECT_EQ(result.cloud.dropped[0].reason, DropReason::kUnreadable);
    EXPECT_EQ(result.cloud.dropped[1].reason, DropReason::kNonFinite);
    std::string most = many_rows(3000, [](std::size_t) { return std::vector<double>{}; });
    for (int i = 0; i < 4000; ++i) most += "broken line here\n";
    expect_load_error("a.xyz", most, ErrorCode::kInvalidInput,
                      "a.xyz:3001: text that is no number; 4000 of 7000 rows");
}

TEST(Text, NumbersAreReadAsFromCharsReadsThem) {
    std::uint64_t seed = 1;
    const auto random = [&](std::uint64_t n) {
        seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
        return (seed >> 33) % n;
    };
    for (int i = 0; i < 200000; ++i) {
        std::string text = random(3) == 0 ? "-" : "";
        const std::uint64_t before = random(9), behind = random(12);
        for (std::uint64_t k = 0; k < before; ++k) text += static_cast<char>('0' + random(10));
        if (behind > 0 || before == 0) text += '.';
        for (std::uint64_t k = 0; k < behind + (before == 0); ++k)
            text += static_cast<char>('0' + random(10));
        if (random(10) == 0) text += "e" + std::to_string(static_cast<int>(random(60)) - 30);
        double wanted = 0.0, got = 0.0;
        std::from_chars(text.data(), text.data() + text.size(), wanted);
        Fields fields(text);
        ASSERT_TRUE(fields.number(got)) << text;
        ASSERT_EQ(std::bit_cast<std::uint64_t>(got), std::bit_cast<std::uint64_t>(wanted)) << text;
    }
    for (const char* text : {"-", ".", "-.", "", "1.2.3", "1-2", "1e", "e5", "--1"}) {
        double value = 0.0;
        EXPECT_FALSE(Fields(text).number(value)) << text;
    }
}

TEST(Text, WordsInAColumnLeaveItOut) {
    const LoadResult result = load_as("a.xyz", "0.5 0 0 C 7\n1 1 1 N 8\n2 2 2 O 9\n");
    EXPECT_EQ(result.cloud.size(), 3U);
    EXPECT_TRUE(has_note(result, "columns are x,y,z,-,intensity"));
    const std::string words_first = "p 0.5 0 0\nn 1 1 1\np 2 2 2\n";
    expect_load_error("a.xyz", words_first, ErrorCode::kInvalidInput,
                      "words among the first three");
    EXPECT_EQ(load_as("a.xyz", words_first, {.columns = "-,x,y,z"}).cloud.size(), 3U);
}

TEST(Text, TheFirstLineThatNamesCoordinatesIsTheHeader) {
    for (const char* units : {"", "m,m,m\n", "#metres\nm,m,m\n"}) {
        const LoadResult result =
            load_as("a.csv", std::string("z,y,x\n") + units + "1.5,2,30\n4,5.5,60\n7,8,99\n");
        EXPECT_EQ(result.cloud.positions[point_of_row(result.cloud, 0)], (Vec3d{30, 2, 1.5}));
        EXPECT_EQ(result.report.num_left_out, 0U);
        EXPECT_TRUE(has_note(result, "columns are z,y,x, by the header"));
    }
    const LoadResult prose = load_as("a.csv", "these are x y z and more\nz y x\n1.5 2 3\n5 6 7\n");
    EXPECT_TRUE(has_note(prose, "columns are z,y,x, by the header"));
    EXPECT_EQ(prose.report.num_left_out, 0U);
    // Of two headers the one that fits
    EXPECT_TRUE(has_note(load_as("a.csv", "# x y z in metres\nz,y,x,i\n1.5,2,3,4\n5,6,7,8\n"),
                         "columns are z,y,x,i, by the header"));
}

TEST(Text, BadRowsInFrontAreCounted) {
    const LoadResult numbers = load_as("a.xyz", "1 2\n3.5 4 5\n6 7 8\n1 1 2\n");
    EXPECT_EQ(numbers.report.num_rows, 4U);
    EXPECT_EQ(numbers.report.num_left_out, 1U);
    const LoadResult quoted =
        load_as("a.csv", "x,y,z\n\"1,5\",\"2\",\"3\"\n\"4\",\"5\",\"6\"\n\"7\",\"8\",\"9\"\n");
    EXPECT_EQ(quoted.report.num_left_out, 1U);
    EXPECT_EQ(quoted.cloud.size(), 2U);
    EXPECT_EQ(load_as("a.txt", "Points: 2\n1 2 3.5\n4 5 6\n").report.num_rows, 2U);
}

TEST(Text, EmptyLastFieldsAreFields) {
    for (const std::string s : {",", ";", "\t"}) {
        SCOPED_TRACE(s);
        const auto line = [&](const std::string& a, const std::string& i) {
            return a + s + "2" + s + "3" + s + i + "\n";
        };
        const std::string head = "y" + s + "x" + s + "z" + s + "i\n";
        const LoadResult some =
            load_as("a.csv", head + line("1.5", "") + line("2", "4.5") + line("5", "") +
                                 line("6", "") + line("8", "4"));
        EXPECT_EQ(some.report.num_left_out, 0U);
        EXPECT_EQ(some.cloud.positions[point_of_row(some.cloud, 0)], (Vec3d{2, 1.5, 3}));
        const Channel* const i = find_channel(some.cloud, "i");
        ASSERT_NE(i, nullptr);
        EXPECT_TRUE(std::isnan(i->data[point_of_row(some.cloud, 0)]));
        EXPECT_EQ(i->data[point_of_row(some.cloud, 1)], 4.5F);
        const LoadResult none = load_as("a.csv", head + line("1.5", "") + line("2", ""));
        EXPECT_EQ(none.cloud.size(), 2U);
        EXPECT_EQ(none.cloud.positions[point_of_row(none.cloud, 0)], (Vec3d{2, 1.5, 3}));
        // One more than there are names
        const LoadResult more =
            load_as("a.csv", "z" + s + "y" + s + "x\n" + line("1.5", "") + line("2", ""));
        EXPECT_EQ(more.cloud.positions[point_of_row(more.cloud, 0)], (Vec3d{3, 2, 1.5}));
        // In some rows only
        const LoadResult mixed = load_as(
            "a.csv", "1.5" + s + "2" + s + "3\n" + line("2", "") + "4" + s + "5" + s + "6\n");
        EXPECT_EQ(mixed.cloud.size(), 3U);
    }
    EXPECT_EQ(load_as("a.csv", "x,y,z\n1,2,3\n4,5,6\n7,8,9,,\n").report.num_left_out, 1U);
}

TEST(Text, ColorsOfWholeFloatsAreFloats) {
    const std::string rows = "0.5,0,0,1.0,0.0,0.0\n1.5,1,1,0.0,1.0,0.0\n";
    for (const char* head : {"x,y,z,r,g,b\n", ""}) {
        const PointCloud cloud = load_as("a.csv", head + rows).cloud;
        ASSERT_EQ(cloud.colors.size(), 2U);
        EXPECT_EQ(cloud.colors[point_of_row(cloud, 0)], rgb16_from_8bit(255, 0, 0));
        EXPECT_EQ(cloud.colors[point_of_row(cloud, 1)], rgb16_from_8bit(0, 255, 0));
    }
    const PointCloud bytes = load_as("a.csv", "0.5,0,0,255.0,1.0,0.0\n1.5,1,1,7.0,2.0,0.0\n").cloud;
    EXPECT_EQ(bytes.colors[point_of_row(bytes, 0)], rgb16_from_8bit(255, 1, 0));
    // A plane's normals, and those of a file that should have some
    EXPECT_FALSE(
        load_as("a.xyzn", "0.5 0 0 1.0 0.0 0.0\n1 1 0 0.0 0.0 1.0\n").cloud.normals.empty());
    EXPECT_FALSE(
        load_as("a.xyz", "0.5 0 0 0.0 0.0 1.0\n1 1 0 0.0 0.0 1.0\n").cloud.normals.empty());
}

TEST(Text, ColumnsWithoutNumbersAreNoColors) {
    const LoadResult result = load_as("a.xyz", "0.5 0 0 nan nan nan\n1 1 1 nan nan nan\n");
    EXPECT_TRUE(result.cloud.colors.empty());
    expect_load_error("a.csv", "x,y,z,r,g,b\nN/A,2,3,1,2,3\nN/A,2,3,1,2,3\n1.5,2,3,9,9,9\n",
                      ErrorCode::kInvalidInput, "column 'x' holds no numbers in most");
}

TEST(Text, CommasSeparateAloneWhereTheyDo) {
    const LoadResult words =
        load_as("a.csv", "x,y,z,label,i\n0.5,0,0,road,1\n1.5,1,1,big tree,2\n2.5 , 4 ,2,a 5 b,3\n");
    EXPECT_EQ(words.cloud.size(), 3U);
    EXPECT_EQ(find_channel(words.cloud, "i")->data[point_of_row(words.cloud, 2)], 3.0F);
    const LoadResult quoted =
        load_as("a.csv",
                "\"x\",\"y\",\"z\",\"name, long\",\"i\"\n\"0.5\",\"0\",\"0\",\"hi, \"\"you\"\" 0\","
                "\"1\"\n\"1\",\"1\",\"1\",\"\"\"\",\"\"\n");
    EXPECT_EQ(quoted.cloud.size(), 2U);
    EXPECT_EQ(quoted.report.num_left_out, 0U);
    EXPECT_EQ(find_channel(quoted.cloud, "i")->data[point_of_row(quoted.cloud, 0)], 1.0F);
    // Both kinds in one row
    const LoadResult both = load_as("a.txt", "0.5,1,2 255 0 7\n3,4,5 1 2 3\n");
    EXPECT_EQ(both.cloud.colors.size(), 2U);
}

TEST(Text, CommentsMayBeLongerThanTheSample) {
    std::string comments;
    for (int i = 0; i < 5000; ++i) comments += "# one of very many lines of comment\n";
    const LoadResult result = load_as("a.txt", comments + "# z y x\n1.5 2 3\n4 5 6\n");
    EXPECT_EQ(result.cloud.positions[point_of_row(result.cloud, 0)], (Vec3d{3, 2, 1.5}));
}

TEST(Text, ZerosBehindATableAreNoHarmAndElsewhereTold) {
    EXPECT_EQ(load_as("a.xyz", "0.5 1 2\n3 4 5\n" + std::string(5, '\0')).cloud.size(), 2U);
    expect_load_error("a.xyz", std::string("0.5 1 2\n\0 3 4 5\n", 16), ErrorCode::kInvalidInput,
                      "byte 8 is zero, which text has not");
    expect_load_error("a.xyz",
                      std::string("\xff\xfe"
                                  "1\0"
                                  " \0"
                                  "2\0",
                                  8),
                      ErrorCode::kUnsupported, "UTF-16");
}

TEST(Text, NumbersTooSmallAreZero) {
    const std::string tiny = "0." + std::string(400, '0') + "1", huge = std::string(400, '9');
    const PointCloud cloud = load_as("a.xyz", tiny + " 1 -" + tiny + "\n2 3 4.5\n").cloud;
    ASSERT_EQ(cloud.size(), 2U);
    EXPECT_EQ(cloud.positions[point_of_row(cloud, 0)], (Vec3d{0, 1, 0}));
    EXPECT_EQ(load_as("a.xyz", huge + ".5 1 2\n2 3 4.5\n").report.num_non_finite, 1U);
}

TEST(Text, DecimalCommasAreToldAbout) {
    for (const char* body : {"1,5 2,5 3,5\n2,5 3,5 4,5\n", "1,5;2,5;3,5;7\n2,5;3,5;4;8\n",
                             "1,5\t2\t3,5\n2,5\t3,5\t4,5\n"})
        expect_load_error("a.txt", body, ErrorCode::kInvalidInput,
                          "a.txt:1: numbers with decimal commas");
    EXPECT_EQ(load_as("a.txt", "1, 5, 2\n2, 3, 4\n").cloud.size(), 2U);
    EXPECT_EQ(load_as("a.txt", "1,5,2\n2,3,4\n").cloud.size(), 2U);
}

TEST(Text, WhatIsNoTableIsNamed) {
    for (const char* text : {"", "\n\n\n", "# only\n", "1 2\n3 4\n", "hello\nworld\n", "7\n"}) {
        const Error error = error_of([&] { load_as("a.xyz", text); });
        EXPECT_EQ(error.code(), ErrorCode::kInvalidInput) << error.what();
        EXPECT_THROW(load_as("a", text), Error);
    }
    expect_load_error("a", "1 2\n3 4\n", ErrorCode::kUnsupported, "of an unknown kind");
    expect_load_error("a", std::string("1 2 3\n4 5 \0\n", 12), ErrorCode::kUnsupported, "unknown");
    expect_load_error("a",
                      "\xff\xfe"
                      "1\0",
                      ErrorCode::kUnsupported, "UTF-16");
    expect_load_error("a.csv", "nan nan nan\n", ErrorCode::kEmpty, "finite coordinates");
    expect_load_error("a.txt", std::string(10 << 20, 'x'), ErrorCode::kInvalidInput, "no table");
}

TEST(Text, LongLinesAndStrangeBytesDoNoHarm) {
    std::string rows = "0 0.5 1\n2 2 2\n3 3 3\n4 4 4\n";
    EXPECT_EQ(load_as("a.xyz", rows + std::string(10 << 20, '7') + "\n5 5 5\n").cloud.size(), 5U);
    std::string wide;
    for (int i = 0; i < 1 << 20; ++i) wide += "1.5 ";
    EXPECT_EQ(load_as("a.xyz", rows + wide + "\n").report.num_left_out, 1U);
    std::string far(1 << 17, '\n');
    EXPECT_EQ(load_as("a.xyz", rows + far + std::string("6 \0 6\n", 6)).report.num_left_out, 1U);
}

TEST(Text, EveryCutAndEveryFlipIsAnErrorOrACloud) {
    const std::string whole = "//X,Y,Z,R,G,B\n1.5,2,3,255,0,7\n4,5,6,1,2,3\n7,8,9,4,5,6\n";
    const TempFolder folder;
    const auto try_to_read = [&](const std::string& bytes) {
        try {
            EXPECT_LE(load_cloud(folder.write("a.csv", bytes)).report.num_rows, 5U);
        } catch (const Error& error) {
            EXPECT_FALSE(std::string(error.what()).empty());
        }
    };
    for (std::size_t i = 0; i < whole.size(); ++i) {
        try_to_read(whole.substr(0, i));
        for (int flip = 1; flip < 256; flip += 18) {
            std::string bytes = whole;
            bytes[i] = static_cast<char>(bytes[i] ^ flip);
            try_to_read(bytes);
        }
    }
}

TEST(Text, ManyRowsAreTheSameForAnyNumberOfThreads) {
    const std::string body = many_rows(50000, [](std::size_t i) {
        return std::vector<double>{static_cast<double>(i % 200), 2, 3};
    });
    const LoadResult one = load_as("a.xyz", body, {}, {.threads = 1});
    const LoadResult four = load_as("a.xyz", body, {}, {.threads = 4});
    EXPECT_EQ(one.cloud.positions, four.cloud.positions);
    EXPECT_EQ(one.cloud.colors, four.cloud.colors);
    EXPECT_EQ(one.report.notes, four.report.notes);
    EXPECT_EQ(one.cloud.size(), 50000U);
}

}  // namespace
}  // namespace pointbake::test
