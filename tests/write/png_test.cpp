#include "write/png.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pointbake/write.h"
#include "write/write_fixtures.h"

namespace pointbake {
namespace {

using fixtures::decode_png;
using fixtures::error_of;
using fixtures::Folder;
using fixtures::random_image;
using ::testing::IsEmpty;

void expect_round_trip(const Image& image) {
    const std::vector<std::byte> png = encode_png(image);
    const Image back = decode_png(png.data(), png.size());
    EXPECT_EQ(back.width, image.width);
    EXPECT_EQ(back.height, image.height);
    EXPECT_EQ(back.num_channels, image.num_channels);
    EXPECT_TRUE(back.pixels == image.pixels) << image.width << " x " << image.height;
}

/// Value by x, y and channel.
template <class Value>
Image image_of(int width, int height, int num_channels, Value&& value) {
    Image image{.width = width, .height = height, .num_channels = num_channels, .pixels = {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < num_channels; ++c)
                image.pixels.push_back(static_cast<std::uint8_t>(value(x, y, c)));
    return image;
}

TEST(Png, ComesBackForAllSizesAndChannels) {
    for (int channels = 1; channels <= 4; ++channels)
        for (const auto& [w, h] : {std::pair{1, 1}, {1, 300}, {300, 1}, {2, 2}, {17, 31}, {64, 5}})
            expect_round_trip(random_image(w, h, channels, static_cast<std::uint64_t>(w * h)));
}

TEST(Png, ComesBackForImagesOfManyBands) {
    expect_round_trip(random_image(1000, 1100, 3, 5));
    expect_round_trip(image_of(1500, 1500, 3, [](int x, int y, int c) { return x / 7 + y * c; }));
}

TEST(Png, ComesBackForImagesThatSuitEachFilter) {
    expect_round_trip(image_of(90, 90, 3, [](int, int, int) { return 77; }));
    expect_round_trip(image_of(90, 90, 3, [](int x, int, int c) { return 3 * x + c; }));
    expect_round_trip(image_of(90, 90, 3, [](int, int y, int c) { return 5 * y + c; }));
    expect_round_trip(image_of(90, 90, 1, [](int x, int y, int) { return x + y; }));
    expect_round_trip(image_of(90, 90, 4, [](int x, int y, int c) { return (x * y + c) / 9; }));
    expect_round_trip(image_of(90, 90, 3, [](int x, int y, int) { return (x ^ y) & 1 ? 255 : 0; }));
}

TEST(Png, SmoothImagesBecomeSmall) {
    const Image gradient =
        image_of(512, 512, 3, [](int x, int y, int c) { return (x + y + c) / 4; });
    EXPECT_LT(encode_png(gradient).size(), gradient.pixels.size() / 50);
    const Image constant = image_of(512, 512, 3, [](int, int, int) { return 200; });
    EXPECT_LT(encode_png(constant).size(), 2000U);
}

TEST(Png, SameBytesForAnyNumberOfThreads) {
    const Image image = random_image(900, 900, 3, 9);
    const std::vector<std::byte> one = encode_png(image, {.threads = 1});
    EXPECT_EQ(one, encode_png(image, {.threads = 7}));
    EXPECT_EQ(one, encode_png(image, {.threads = 7}));
}

TEST(Png, RefusesImagesWhoseSizesDoNotFit) {
    const auto code = [](const Image& image) { return error_of([&] { encode_png(image); })->code; };
    EXPECT_EQ(code({.width = 0, .height = 4, .num_channels = 3, .pixels = {}}),
              ErrorCode::kInvalidInput);
    EXPECT_EQ(code({.width = 1, .height = 1, .num_channels = 3, .pixels = {1, 2}}),
              ErrorCode::kInvalidInput);
    EXPECT_EQ(code({.width = 1, .height = 1, .num_channels = 5, .pixels = {1, 2, 3, 4, 5}}),
              ErrorCode::kInvalidInput);
}

TEST(Png, StopsWhenCancelledAndLeavesNothing) {
    const Folder folder;
    std::stop_source stop;
    stop.request_stop();
    const auto thrown = error_of([&] {
        write_png(random_image(900, 900, 3, 9), folder / "a.png", {.stop = stop.get_token()});
    });
    ASSERT_TRUE(thrown);
    EXPECT_EQ(thrown->code, ErrorCode::kCancelled);
    EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(Png, WriteMakesTheFile) {
    const Folder folder;
    const Image image = random_image(33, 20, 3, 1);
    write_png(image, folder / "a.png");
    const std::string bytes = fixtures::read_text(folder / "a.png");
    EXPECT_EQ(decode_png(bytes.data(), bytes.size()).pixels, image.pixels);
}

}  // namespace
}  // namespace pointbake
