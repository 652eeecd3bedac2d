// LAZ: against uncompressed twins that other programs wrote, with tables of chunks that lie, and
// damaged.
#include "io/las_files.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

namespace fs = std::filesystem;

fs::path data_file(const std::string& name) {
    const char* elsewhere = std::getenv("POINTBAKE_DATA");
    return (elsewhere != nullptr ? fs::path(elsewhere) : fs::path(POINTBAKE_TEST_DATA)) / name;
}

std::string read_bytes(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Chunks of one point each need no decoding: a record, and four bytes that begin the coder's.
std::string lone_points(int num_points) {
    std::string out(8, '\0');
    for (int i = 0; i < num_points; ++i) out += las_record(0, {i, 2 * i, 0}) + std::string(4, '\0');
    return out;
}

TestLas lone_point_file(int num_points) {
    return {2,
            128,
            {laz_vlr(2, 1)},
            lone_points(num_points),
            20,
            static_cast<std::uint64_t>(num_points)};
}

TEST(Laz, ReadsChunksWithoutATable) {
    for (const std::uint64_t place : {0ULL, 1ULL, 300ULL, 1ULL << 40, ~0ULL}) {
        std::string bytes = lone_point_file(3).bytes();
        put(bytes, 227 + 54 + 40, place);
        const LoadResult result = load_as("a.laz", bytes);
        EXPECT_EQ(result.report.format, "LAZ 1.2, point format 0");
        ASSERT_EQ(result.cloud.size(), 3U);
        EXPECT_EQ(result.cloud.positions[point_of_row(result.cloud, 2)], (Vec3d{1001, 2002, 3000}));
        EXPECT_TRUE(has_note(result, "the table of chunks is missing or wrong"));
    }
}

TEST(Laz, WhatCannotBeReadIsToldClearly) {
    const ErrorCode damaged = ErrorCode::kInvalidInput, unknown = ErrorCode::kUnsupported;
    TestLas las = lone_point_file(2);
    las.num_points = 4;
    expect_load_error("a.laz", las.bytes(), damaged, "a.laz: byte 377: 1 points are promised");
    las.num_points = 1ULL << 31;
    expect_load_error("a.laz", las.bytes(), ErrorCode::kLimit, "is not believed");
    las = lone_point_file(2);
    las.vlrs.clear();
    expect_load_error("a.laz", las.bytes(), damaged, "no record 'laszip encoded'");
    las.vlrs = {laz_vlr(4, 1)};
    expect_load_error("a.laz", las.bytes(), unknown, "LAZ compressor 4");
    las.vlrs = {laz_vlr(2, 0)};
    expect_load_error("a.laz", las.bytes(), damaged, "chunks of 0 points");
    las.vlrs = {laz_vlr(2, 1, 6, 1)};
    expect_load_error("a.laz", las.bytes(), unknown, "LAZ item 6 of version 1");
    las.vlrs = {laz_vlr(2, 1, 9, 1)};
    expect_load_error("a.laz", las.bytes(), unknown, "compressed wave packets");
    las.vlrs = {laz_vlr(2, 1, 0, 2)};
    expect_load_error("a.laz", las.bytes(), damaged, "the parts of a compressed point");
    las.vlrs = {laz_vlr(2, 1)};
    las.vlrs[0].data.resize(39);
    expect_load_error("a.laz", las.bytes(), damaged, "'laszip encoded' is cut off");
    las.vlrs = {laz_vlr(2, 1)};
    las.record_bytes = 22;
    expect_load_error("a.laz", las.bytes(), damaged, "have 20 bytes together");
}

/// The same points, and the same values of all they carry.
void expect_same(const PointCloud& a, const PointCloud& b) {
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.colors, b.colors);
    EXPECT_EQ(a.rows, b.rows);
    ASSERT_EQ(a.channels.size(), b.channels.size());
    for (std::size_t k = 0; k < a.channels.size(); ++k) {
        EXPECT_EQ(a.channels[k].name, b.channels[k].name);
        EXPECT_EQ(std::memcmp(a.channels[k].data.data(), b.channels[k].data.data(),
                              a.channels[k].data.size() * sizeof(float)),
                  0)
            << a.channels[k].name;
    }
}

TEST(Laz, HoldsWhatItsTwinHolds) {
    if (!fs::exists(data_file("loaders")))
        GTEST_SKIP() << "no test data in " << data_file("") << "; POINTBAKE_DATA names another";
    for (const char* name :
         {"laspy_simple", "pdal_simple", "laspy_1_4_w_evlr", "loadersgl_pdrf6-1.4",
          "loadersgl_pdrf7-v4-1.4", "loadersgl_pdrf8-1.4", "loadersgl_pdrf9-1.4",
          "loadersgl_pdrf9-1.5", "loadersgl_pdrf10-1.4", "loadersgl_pdrf10-1.5"}) {
        SCOPED_TRACE(name);
        const std::string path = "loaders/" + std::string(name);
        const LoadResult las = load_cloud(data_file(path + ".las"));
        for (const int threads : {1, 3})
            expect_same(las.cloud,
                        load_cloud(data_file(path + ".laz"), {}, {.threads = threads}).cloud);
    }
}

TEST(Laz, ReadsWithoutItsTableWhatItReadsWithIt) {
    if (!fs::exists(data_file("loaders")))
        GTEST_SKIP() << "no test data in " << data_file("") << "; POINTBAKE_DATA names another";
    for (const char* name : {"laspy_plane.laz", "loadersgl_pdrf8-1.4.laz"}) {
        SCOPED_TRACE(name);
        std::string bytes = read_bytes(data_file("loaders/" + std::string(name)));
        const LoadResult with = load_as("a.laz", bytes);
        std::uint32_t points_at = 0;
        std::memcpy(&points_at, bytes.data() + 96, 4);
        put<std::uint64_t>(bytes, points_at, 0);
        const LoadResult without = load_as("a.laz", bytes);
        EXPECT_TRUE(has_note(without, "the table of chunks is missing or wrong"));
        expect_same(with.cloud, without.cloud);
    }
}

TEST(Laz, DamagedFilesAreErrorsOrClouds) {
    if (!fs::exists(data_file("loaders")))
        GTEST_SKIP() << "no test data in " << data_file("") << "; POINTBAKE_DATA names another";
    const TempFolder folder;
    const auto try_to_read = [&](const std::string& bytes) {
        try {
            load_cloud(folder.write("a.laz", bytes));
        } catch (const Error& error) {
            EXPECT_FALSE(std::string(error.what()).empty());
        }
    };
    for (const char* name : {"pdal_simple.laz", "laspy_extra.laz", "loadersgl_pdrf10-1.4.laz",
                             "laspy_simple.copc.laz"}) {
        const std::string whole = read_bytes(data_file("loaders/" + std::string(name)));
        for (std::size_t i = 0; i < 120; ++i) {
            try_to_read(whole.substr(0, i * whole.size() / 120));
            std::string bytes = whole;
            const std::size_t at = i < 60 ? i * 30 % 2400 : i * 7919 % whole.size();
            bytes[at] = static_cast<char>(bytes[at] ^ static_cast<int>(1U << i % 8));
            try_to_read(bytes);
        }
    }
}

}  // namespace
}  // namespace pointbake::test
