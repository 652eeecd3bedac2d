// LAS: versions, point formats, extra bytes, withheld points, headers that lie.
#include "core/color.h"
#include "io/las_files.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

TEST(Las, ReadsEveryVersionAndPointFormat) {
    for (int minor = 0; minor <= 5; ++minor)
        for (int format = 0; format <= 10; ++format) {
            SCOPED_TRACE(testing::Message() << "1." << minor << ", format " << format);
            const bool is_new = format >= 6;
            std::string a = las_record(format, {2, 4, -6}), b = las_record(format, {3, 5, 7});
            put<std::uint16_t>(a, 12, 700);
            put<std::uint8_t>(a, 14, is_new ? 0x52 : 0x2a);  // return 2 of 5
            put<std::uint8_t>(a, is_new ? 16 : 15, is_new ? 200 : 0x26);
            put<std::uint8_t>(a, 17, 9);
            if (is_new)
                put<std::int16_t>(a, 18, -1000);
            else
                put<std::int8_t>(a, 16, -6);
            put<std::uint16_t>(a, is_new ? 20 : 18, 77);
            const LoadResult result = load_as("a.bin", TestLas{minor, format, {}, a + b}.bytes());
            const PointCloud& cloud = result.cloud;
            ASSERT_EQ(cloud.size(), 2U);
            const std::size_t i = point_of_row(cloud, 0);
            EXPECT_EQ(cloud.positions[i], (Vec3d{1001, 2002, 2997}));
            const auto value = [&](const char* name) { return find_channel(cloud, name)->data[i]; };
            EXPECT_EQ(value("intensity"), 700.0F);
            EXPECT_EQ(value("return_number"), 2.0F);
            EXPECT_EQ(value("number_of_returns"), 5.0F);
            EXPECT_EQ(value("classification"), is_new ? 200.0F : 6.0F);
            EXPECT_EQ(find_channel(cloud, "classification")->kind, ChannelKind::kCategory);
            EXPECT_EQ(value("scan_angle"), -6.0F);
            EXPECT_EQ(value("user_data"), 9.0F);
            EXPECT_EQ(value("point_source_id"), 77.0F);
            EXPECT_TRUE(cloud.colors.empty());  // those of formats that have them are all black
        }
}

TEST(Las, ReadsColorsTimesAndNearInfrared) {
    const auto color_at = [](int format) -> std::size_t {
        return format >= 7 ? 30 : format == 2 ? 20 : 28;
    };
    for (const int format : {2, 3, 5, 7, 8, 10}) {
        SCOPED_TRACE(format);
        std::string a = las_record(format, {0, 0, 0}), b = las_record(format, {1, 0, 0});
        put<std::uint16_t>(a, color_at(format), 65535);
        put<std::uint16_t>(b, color_at(format) + 4, 300);
        if (format != 2) put(a, format >= 7 ? 22 : 20, 1.5);
        if (format == 8 || format == 10) put<std::uint16_t>(b, 36, 4000);
        const LoadResult result = load_as("a.las", TestLas{4, format, {}, a + b}.bytes());
        const std::size_t i = point_of_row(result.cloud, 0), j = point_of_row(result.cloud, 1);
        EXPECT_EQ(result.cloud.colors[i], (Rgb16{65535, 0, 0}));
        EXPECT_EQ(result.cloud.colors[j], (Rgb16{0, 0, 300}));
        EXPECT_TRUE(has_note(result, "colours are integers from 0 to 65535"));
        const Channel* time = find_channel(result.cloud, "gps_time");
        EXPECT_EQ(time == nullptr ? 1.5F : time->data[i], 1.5F);
        EXPECT_EQ(time == nullptr, format == 2);
        const Channel* nir = find_channel(result.cloud, "nir");
        EXPECT_EQ(nir == nullptr ? 4000.0F : nir->data[j], 4000.0F);
        EXPECT_EQ(nir != nullptr, format == 8 || format == 10);
    }
}

TEST(Las, SmallColorsHaveEightBits) {
    std::string a = las_record(2, {0, 0, 0}), b = las_record(2, {1, 0, 0});
    put<std::uint16_t>(a, 20, 255);
    put<std::uint16_t>(b, 22, 128);
    const LoadResult result = load_as("a.las", TestLas{2, 2, {}, a + b}.bytes());
    EXPECT_EQ(result.cloud.colors[point_of_row(result.cloud, 1)], rgb16_from_8bit(0, 128, 0));
    EXPECT_TRUE(has_note(result, "colours are integers from 0 to 255"));
    EXPECT_TRUE(has_note(result, "0 in all records, left out: intensity, return_number"));
}

TEST(Las, ReadsExtraBytesAsTheyAreDescribed) {
    std::string scaled = extra_descriptor(4, "height above");
    put<std::uint8_t>(scaled, 3, 8 | 16);
    put(scaled, 112, 0.25);
    put(scaled, 136, 10.0);
    std::string missing = extra_descriptor(9, "amplitude");
    put<std::uint8_t>(missing, 3, 1);
    put(missing, 40, -1.0);
    std::string skipped = extra_descriptor(0, "");
    put<std::uint8_t>(skipped, 3, 3);
    std::string a = las_record(0, {0, 0, 0}, 13), b = las_record(0, {1, 0, 0}, 13);
    put<std::int16_t>(a, 20, -8);
    put(a, 25, -1.0F);
    put(b, 25, 2.5F);
    put<std::uint8_t>(b, 30, 200);
    put<std::uint8_t>(b, 32, 201);
    TestLas las{
        2,
        0,
        {{"LASF_Spec", 4,
          scaled + skipped + missing + extra_descriptor(1, "a") + extra_descriptor(10, "too far")}},
        a + b,
        33};
    // The three bytes that are skipped lie behind the height; `a` is the one behind the amplitude.
    const LoadResult result = load_as("a.las", las.bytes());
    const std::size_t i = point_of_row(result.cloud, 0), j = point_of_row(result.cloud, 1);
    EXPECT_EQ(find_channel(result.cloud, "height above")->data[i], 8.0F);
    EXPECT_EQ(find_channel(result.cloud, "height above")->data[j], 10.0F);
    EXPECT_TRUE(std::isnan(find_channel(result.cloud, "amplitude")->data[i]));
    EXPECT_EQ(find_channel(result.cloud, "amplitude")->data[j], 2.5F);
    EXPECT_TRUE(has_note(result, "extra bytes from 'too far' on ignored"));
}

TEST(Las, DropsWithheldPoints) {
    for (const int format : {1, 6}) {
        std::string a = las_record(format, {0, 0, 0}), b = las_record(format, {1, 0, 0});
        put<std::uint8_t>(a, 15, format == 1 ? 0x82 : 0x04);
        const LoadResult result = load_as("a.las", TestLas{4, format, {}, a + b}.bytes());
        ASSERT_EQ(result.cloud.size(), 1U);
        EXPECT_EQ(result.cloud.rows[0], 1U);
        ASSERT_EQ(result.cloud.dropped.size(), 1U);
        EXPECT_EQ(result.cloud.dropped[0].reason, DropReason::kWithheld);
        EXPECT_EQ(result.cloud.dropped[0].position, (Vec3d{1000, 2000, 3000}));
        EXPECT_EQ(result.report.num_left_out, 1U);
        EXPECT_TRUE(has_note(result, "1 point marked as withheld: dropped"));
    }
}

TEST(Las, TheLegacyCountOfNewFilesIsNotBelieved) {
    std::string bytes =
        TestLas{4, 6, {}, las_record(6, {0, 0, 0}) + las_record(6, {1, 0, 0})}.bytes();
    put<std::uint32_t>(bytes, 107, 4000000000U);
    EXPECT_EQ(load_as("a.las", bytes).report.num_rows, 2U);
    put<std::uint32_t>(bytes, 107, 1);
    put<std::uint64_t>(bytes, 247, 0);
    EXPECT_TRUE(has_note(load_as("a.las", bytes), "the count of 64 bits is 0"));
}

TEST(Las, HeadersThatLieAreErrors) {
    const ErrorCode code = ErrorCode::kInvalidInput;
    const TestLas good{2, 0, {}, las_record(0, {0, 0, 0}) + las_record(0, {1, 0, 0})};
    const auto expect = [&](auto&& change, ErrorCode wanted, const std::string& part) {
        std::string bytes = good.bytes();
        change(bytes);
        expect_load_error("a.las", bytes, wanted, part);
    };
    expect([](std::string& b) { put<std::uint32_t>(b, 107, 3); }, code,
           "a.las: the header promises 3 points, but bytes are there for only 2 (the file ends at "
           "byte 267)");
    expect([](std::string& b) { put<std::uint32_t>(b, 107, 0); }, ErrorCode::kEmpty, "0 points");
    expect([](std::string& b) { put<std::uint32_t>(b, 96, 1U << 31); }, code,
           "byte 96: the points are said to begin at byte 2147483648");
    expect([](std::string& b) { put<std::uint32_t>(b, 96, 4); }, code, "byte 96");
    expect([](std::string& b) { put<std::uint16_t>(b, 94, 100); }, code, "byte 94");
    expect([](std::string& b) { put<std::uint8_t>(b, 25, 4); }, code, "has 375 at least");
    expect([](std::string& b) { put<std::uint8_t>(b, 24, 2); }, ErrorCode::kUnsupported,
           "LAS of version 2.2; 1.0 to 1.5 are read");
    expect([](std::string& b) { put<std::uint8_t>(b, 104, 11); }, ErrorCode::kUnsupported,
           "point format 11; 0 to 10 are read");
    expect([](std::string& b) { put<std::uint16_t>(b, 105, 19); }, code,
           "records of 19 bytes; those of point format 0 have 20 at least");
    expect([](std::string& b) { put(b, 139, 0.0); }, code, "byte 139: coordinates are scaled by 0");
    expect([](std::string& b) { b.resize(100); }, code, "the header is cut off at byte 100");
}

TEST(Las, RecordsThatAreNotThereAreNoted) {
    std::string bytes = TestLas{4, 6, {{"x", 1, "abc"}}, las_record(6, {0, 0, 0})}.bytes();
    put<std::uint32_t>(bytes, 100, 5);
    put<std::uint64_t>(bytes, 235, ~0ULL);
    put<std::uint32_t>(bytes, 243, 7);
    const LoadResult result = load_as("a.las", bytes);
    EXPECT_TRUE(has_note(result, "1 of 5 variable length records are there before the points"));
    EXPECT_TRUE(has_note(result, "0 of 7 extended variable length records are there"));
}

TEST(Las, TheNumberOfThreadsDoesNotMatter) {
    std::string points;
    for (int i = 0; i < 30000; ++i) {
        std::string record = las_record(3, {i * 7919 % 1009, i * 1049 % 1013, i % 17});
        put(record, 12, static_cast<std::uint16_t>(i));
        put(record, 28, static_cast<std::uint16_t>(i * 2));
        points += record;
    }
    const std::string bytes = TestLas{3, 3, {}, points}.bytes();
    const LoadResult one = load_as("a.las", bytes, {}, {.threads = 1});
    const LoadResult four = load_as("a.las", bytes, {}, {.threads = 4});
    EXPECT_EQ(one.cloud.positions, four.cloud.positions);
    EXPECT_EQ(one.cloud.colors, four.cloud.colors);
    EXPECT_EQ(one.cloud.rows, four.cloud.rows);
    EXPECT_EQ(one.cloud.channels[0].data, four.cloud.channels[0].data);
}

TEST(Las, EveryCutAndFlipIsAnErrorOrACloud) {
    const std::string whole = TestLas{4,
                                      7,
                                      {{"LASF_Spec", 4, extra_descriptor(3, "a")}},
                                      las_record(7, {0, 0, 0}, 2) + las_record(7, {1, 2, 3}, 2),
                                      38}
                                  .bytes();
    const TempFolder folder;
    const auto try_to_read = [&](const std::string& bytes) {
        try {
            EXPECT_LE(load_cloud(folder.write("a.las", bytes)).report.num_rows, 30U);
        } catch (const Error& error) {
            EXPECT_FALSE(std::string(error.what()).empty());
        }
    };
    for (std::size_t i = 0; i < whole.size(); i += i < 400 ? 1 : 7) {
        try_to_read(whole.substr(0, i));
        for (const int flip : {1, 16, 128, 255}) {
            std::string bytes = whole;
            bytes[i] = static_cast<char>(bytes[i] ^ flip);
            try_to_read(bytes);
        }
    }
}

}  // namespace
}  // namespace pointbake::test
