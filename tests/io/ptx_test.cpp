// PTX: scans with places of their own, empty returns, counts that lie.
#include "core/color.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

const std::string kNoTurn = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";

TEST(Ptx, ReadsAScanWithItsPlace) {
    // A quarter turn about z, and far away.
    const std::string bytes =
        "2\n2\n500000 5000000 10\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n"
        "500000 5000000 10 1\n"
        "1 0 0 0.25 255 0 0\n0 0 0 0.5 0 0 0\n0.001 2 0 1 0 255 0\n0 0 3 0 1 2 3\n";
    const LoadResult result = load_as("a.ptx", bytes);
    const PointCloud& cloud = result.cloud;
    EXPECT_EQ(result.report.format, "PTX");
    EXPECT_EQ(result.report.num_rows, 4U);
    EXPECT_EQ(result.report.num_left_out, 1U);
    EXPECT_TRUE(has_note(result, "1 row without a return (0 0 0): dropped"));
    ASSERT_EQ(cloud.size(), 3U);
    EXPECT_EQ(cloud.dropped[0].reason, DropReason::kNoReturn);
    const std::size_t first = point_of_row(cloud, 0), third = point_of_row(cloud, 2);
    EXPECT_EQ(cloud.positions[first], (Vec3d{500000, 5000001, 10}));
    EXPECT_EQ(cloud.positions[third], (Vec3d{499998, 5000000 + 0.001, 10}));
    EXPECT_EQ(cloud.colors[third], rgb16_from_8bit(0, 255, 0));
    EXPECT_EQ(find_channel(cloud, "intensity")->data[first], 0.25F);
    EXPECT_EQ(result.report.scanners, (std::vector<Vec3d>{{500000, 5000000, 10}}));
    EXPECT_EQ(cloud.sensors[first], (Vec3f{0, -1, 0}));
    EXPECT_EQ(cloud.sensors[point_of_row(cloud, 3)], (Vec3f{0, 0, -1}));
}

TEST(Ptx, ReadsSeveralScans) {
    const std::string moved = "0 0 9\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 9 1\n";
    const std::string bytes = "2\n1\n" + kNoTurn + "1 0 0 1\n5 0 0 1\n\n0\n7\n" + kNoTurn +
                              "1\n2\n" + moved + "1 2 0 0.5 1 2 3\n3 4 5 0.5 4 5 6\n";
    for (const int threads : {1, 3}) {
        const LoadResult result = load_as("a.ptx", bytes, {}, {.threads = threads});
        ASSERT_EQ(result.cloud.size(), 4U);
        EXPECT_EQ(result.cloud.positions[point_of_row(result.cloud, 3)], (Vec3d{3, 4, 14}));
        EXPECT_TRUE(result.cloud.colors.empty());
        EXPECT_TRUE(has_note(result, "2 scans: colours left out, not all have them"));
    }
}

TEST(Ptx, AScannerFarFromItsPointsIsNoSensor) {
    const LoadResult result =
        load_as("a.ptx", "2\n1\n" + kNoTurn + "600000.5 0 0 1\n600001 2 3 1\n");
    EXPECT_TRUE(result.cloud.sensors.empty());
    EXPECT_TRUE(has_note(result, "ignored: far from its points"));
}

TEST(Ptx, CountsThatLieAreErrors) {
    const ErrorCode code = ErrorCode::kInvalidInput;
    const std::string points = "1 2 3 1\n4 5 6 1\n";
    expect_load_error("a.ptx", "3\n1\n" + kNoTurn + points, code,
                      "a.ptx:1: the header of scan 1 promises 3 points, but lines are there for "
                      "only 2");
    expect_load_error("a.ptx", "4000000000\n4000000000\n" + kNoTurn + points, code,
                      "no header of a scan");
    expect_load_error("a.ptx", "1\n1\n" + kNoTurn + points, code, "a.ptx:12: no header of a scan");
    expect_load_error("a.ptx", "0\n1\n" + kNoTurn, ErrorCode::kEmpty, "0 points");
    expect_load_error("a.ptx", "2\n1\n" + kNoTurn + "1 2\n3 4\n", code,
                      "a.ptx:11: 2 numbers; x y z, intensity");
    expect_load_error("a.ptx", "2\n1\n" + kNoTurn + "0 0 0 1\n0 0 0 1\n", ErrorCode::kEmpty,
                      "2 rows without a return");
    expect_load_error("a.ptx", "2\n1\n0 0 0\n", code, "no header of a scan");
}

TEST(Ptx, LoneNumbersAreBadRows) {
    const LoadResult result = load_as("a.ptx", "3\n1\n" + kNoTurn + "1 2 3 1\n7\n4 5 6 1\n");
    EXPECT_EQ(result.report.num_rows, 3U);
    EXPECT_EQ(result.report.num_left_out, 1U);
}

TEST(Ptx, ManySmallScansAreReadInOnePass) {
    std::string bytes;
    constexpr std::size_t kScans = 30000;
    for (std::size_t i = 0; i < kScans; ++i)
        bytes += "1\n1\n" + kNoTurn + std::to_string(i) + ".5 2 3 1\n";
    EXPECT_EQ(load_as("a.ptx", bytes).cloud.size(), kScans);
}

TEST(Ptx, EveryCutAndFlipIsAnErrorOrACloud) {
    const std::string whole =
        "2\n1\n" + kNoTurn + "1 0 0 1\n5 0 0 1\n" + "1\n1\n" + kNoTurn + "1 2 0 0.5\n";
    const TempFolder folder;
    const auto try_to_read = [&](const std::string& bytes) {
        try {
            EXPECT_LE(load_cloud(folder.write("a.ptx", bytes)).report.num_rows, 30U);
        } catch (const Error& error) {
            EXPECT_FALSE(std::string(error.what()).empty());
        }
    };
    for (std::size_t i = 0; i < whole.size(); ++i) {
        try_to_read(whole.substr(0, i));
        for (int flip = 1; flip < 256; flip += 20) {
            std::string bytes = whole;
            bytes[i] = static_cast<char>(bytes[i] ^ flip);
            try_to_read(bytes);
        }
    }
}

}  // namespace
}  // namespace pointbake::test
