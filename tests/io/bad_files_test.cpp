// Files that do not hold what they promise: a clear error, at once, and never a large allocation.
#include <sys/resource.h>

#include <chrono>

#include "io/test_files.h"

namespace pointbake::test {
namespace {

const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";

std::string header(const std::string& format, const std::string& elements) {
    return "ply\nformat " + format + " 1.0\n" + elements + "end_header\n";
}

void expect_error(const std::string& bytes, ErrorCode code, const std::string& part) {
    const Error error = error_of([&] { load_bytes(bytes); });
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos)
        << error.what() << "\nwants: " << part;
}

TEST(BadFiles, PromisesOfManyPointsFailAtOnce) {
    for (const char* format : kFormats)
        for (const char* count : {"4294967295", "18446744073709551615", "12"}) {
            const auto begin = std::chrono::steady_clock::now();
            expect_error(header(format, "element vertex " + std::string(count) + "\n" + kXyz) +
                             "0 0 0\n1 1 1\n",
                         ErrorCode::kInvalidInput,
                         "promises " + std::string(count) +
                             " points, but bytes are there for only " +
                             (std::string(format) == "ascii" ? "2" : "1"));
            EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
        }
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    EXPECT_LT(usage.ru_maxrss, 1 << 20) << "peak memory in kB";
}

TEST(BadFiles, PromisesOfListsAndFacesFail) {
    const std::string two = "element vertex 2\n" + kXyz;
    const std::string face = "element face 4000000000\nproperty list uchar int vertex_indices\n";
    expect_error(header("ascii", two + face) + "0 0 0\n1 1 1\n3 0 1 0\n", ErrorCode::kInvalidInput,
                 "4000000000 faces, but bytes are there for only 1");
    expect_error(header("binary_little_endian", two + face) + std::string(24, '\0'),
                 ErrorCode::kInvalidInput, "faces, but bytes are there for only 0");
    const std::string listed = "element vertex 1\n" + kXyz + "property list uint double weights\n";
    expect_error(
        header("binary_little_endian", listed) + std::string(12, '\0') + "\xff\xff\xff\xff",
        ErrorCode::kInvalidInput, "points, but bytes are there for only 0");
    expect_error(header("ascii", listed) + "0 0 0 4294967295 1\n", ErrorCode::kInvalidInput,
                 ":9: too few values");
    const std::string negative =
        "element vertex 1\n" + kXyz + "property list char double weights\n";
    expect_error(header("binary_little_endian", negative) + std::string(12, '\0') + "\xff",
                 ErrorCode::kInvalidInput, "a list of -1 values");
}

TEST(BadFiles, EveryCutOfABinaryFileFails) {
    const TestElement face{"face", {{"int", "vertex_indices", {{0, 1, 2}, {2, 1, 0}}, "uchar"}}};
    for (const char* format : {"binary_little_endian", "binary_big_endian"}) {
        const std::string whole = make_ply(format, {three_points(), face});
        for (std::size_t size = 0; size < whole.size(); ++size) {
            const Error error = error_of([&] { load_bytes(whole.substr(0, size)); });
            EXPECT_FALSE(std::string(error.what()).empty());
        }
        EXPECT_EQ(load_bytes(whole).cloud.size(), 3U);
    }
}

TEST(BadFiles, EveryCutOfATextFileFailsOrReadsWhole) {
    const std::string whole = make_ply("ascii", {three_points()});
    for (std::size_t size = 0; size < whole.size(); ++size) {
        try {
            EXPECT_EQ(load_bytes(whole.substr(0, size)).report.num_rows, 3U);
        } catch (const Error& error) {
            EXPECT_FALSE(std::string(error.what()).empty());
        }
    }
}

TEST(BadFiles, EveryFlippedByteIsAnErrorOrACloud) {
    const TestElement face{"face", {{"int", "vertex_indices", {{0, 1, 2}, {2, 1, 0}}, "uchar"}}};
    for (const char* format : kFormats) {
        const std::string whole = make_ply(format, {three_points(), face});
        const TempFolder folder;
        for (std::size_t i = 0; i < whole.size(); ++i)
            for (int flip : {0x01, 0x80, 0xff}) {
                std::string bytes = whole;
                bytes[i] = static_cast<char>(bytes[i] ^ flip);
                try {
                    EXPECT_LE(load_cloud(folder.write("a.ply", bytes)).cloud.size(), 3U);
                } catch (const Error&) {
                }
            }
    }
}

TEST(BadFiles, TextThatIsNoNumberNamesItsLine) {
    const std::string head = header("ascii", "element vertex 3\n" + kXyz);  // 7 lines
    expect_error(head + "0 0 0\n1 abc 1\n2 2 2\n", ErrorCode::kInvalidInput,
                 "cloud.ply:9: text that is no number in row 1 of 'vertex'");
    expect_error(head + "0 0 0\n1 1,5 1\n2 2 2\n", ErrorCode::kInvalidInput, "cloud.ply:9: text");
    expect_error(head + "0 0 0\n1 1 1\n\n2 2\n", ErrorCode::kInvalidInput,
                 "cloud.ply:11: too few values in row 2");
    expect_error(head + "0 0 0 7\n1 1 1\n2 2 2\n", ErrorCode::kInvalidInput,
                 "cloud.ply:8: too many values");
}

TEST(BadFiles, HeadersNameTheirLine) {
    const ErrorCode code = ErrorCode::kInvalidInput;
    expect_error("", code, "empty");
    expect_error("ply\n", code, "no 'end_header'");
    expect_error("ply\nend_header\n", code, "no 'format' line");
    expect_error("ply\nformat ascii64 1.0\nend_header\n", code, ":2: unknown format 'ascii64'");
    expect_error("ply\nformat ascii 1.0\nproperty float x\n", code, ":3: 'property' before");
    expect_error("ply\nformat ascii 1.0\nelement vertex -1\n", code, ":3: '-1' is no number");
    expect_error("ply\nformat ascii 1.0\nelement vertex 1e6\n", code, "'1e6' is no number");
    expect_error("ply\nformat ascii 1.0\nelement vertex 3\nproperty real x\n", code,
                 ":4: unknown type 'real'");
    expect_error("ply\nformat ascii 1.0\nelement vertex 3\nproperty list float int x\n", code,
                 ":4: a list's count must be an integer type");
    expect_error("ply\nformat ascii 1.0\nelement vertex 3\nproperty float\n", code,
                 ":4: a property without a name");
    expect_error("ply\nformat ascii 1.0\nelement vertex 3\nporperty float x\n", code,
                 ":4: 'porperty float x' is no header line");
    expect_error("ply\nformat ascii 1.0\n\x01\x02\xff\n", code, "' is no header line");
    expect_error(
        header("ascii", "element vertex 1\nproperty float x\nproperty float y\n") + "0 0\n", code,
        "no scalar property 'z'");
    expect_error(header("ascii", "element face 0\n"), code, "no element 'vertex'");
    expect_error(header("ascii", "element vertex 0\n" + kXyz), ErrorCode::kEmpty, "0 points");
    expect_error(header("ascii", "element vertex 1\n" + kXyz) + "nan nan nan\n", ErrorCode::kEmpty,
                 "none of the 1 points has finite coordinates");
    expect_error(
        header("binary_little_endian", "element vertex 1\nproperty uint packed_position\n") +
            "0000",
        code, "1 compressed splats need 1 rows of 'chunk' before them, but there are 0");
}

TEST(BadFiles, AByteOrderMarkDoesNoHarm) {
    const std::string ply = make_ply("ascii", {three_points()});
    EXPECT_EQ(load_bytes("\xef\xbb\xbf" + ply).cloud.size(), 3U);
    EXPECT_EQ(load_as("a.obj", "\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").cloud.size(),
              3U);
}

TEST(BadFiles, OtherKindsAreNamed) {
    const ErrorCode code = ErrorCode::kUnsupported;
    expect_error("once upon a time", code, "read from PLY");
    expect_error("plywood", code, "read from PLY");
    expect_error(std::string(100, '\0'), code, "read from PLY");
}

TEST(BadFiles, MissingFilesAndFoldersAreNamed) {
    const TempFolder folder;
    const Error missing = error_of([&] { load_cloud(folder.path() / "none.ply"); });
    EXPECT_EQ(missing.code(), ErrorCode::kIo);
    EXPECT_NE(std::string(missing.what()).find("none.ply"), std::string::npos);
    const Error directory = error_of([&] { load_cloud(folder.path()); });
    EXPECT_EQ(directory.code(), ErrorCode::kIo);
    EXPECT_NE(std::string(directory.what()).find("is a directory"), std::string::npos);
}

TEST(BadFiles, StrayLinesBeforeTheFirstElementAreTolerated) {
    const LoadResult result = load_bytes("ply\nformat ascii 1.0\nbye\nbye\nelement vertex 1\n" +
                                         kXyz + "end_header\n1 2 3\nmore\n");
    EXPECT_EQ(result.cloud.positions[0], (Vec3d{1, 2, 3}));
    EXPECT_EQ(result.report.notes.size(), 1U);
}

}  // namespace
}  // namespace pointbake::test
