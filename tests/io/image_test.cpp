#include "io/image_io.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

std::span<const std::byte> bytes_of(const std::string& text) {
    return std::as_bytes(std::span<const char>(text));
}

std::vector<std::uint8_t> ramp(int width, int height) {
    std::vector<std::uint8_t> pixels;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c : {x * 8, y * 8, 100}) pixels.push_back(static_cast<std::uint8_t>(c));
    return pixels;
}

TEST(Images, PngIsExact) {
    const Image image = decode_image(bytes_of(make_png(5, 3, ramp(5, 3))), "a");
    EXPECT_EQ(image.width, 5);
    EXPECT_EQ(image.height, 3);
    EXPECT_EQ(image.num_channels, 3);
    EXPECT_EQ(image.pixels, ramp(5, 3));
}

TEST(Images, JpegIsClose) {
    const Image image = decode_image(bytes_of(make_jpeg(16, 8, ramp(16, 8))), "a");
    ASSERT_EQ(image.pixels.size(), ramp(16, 8).size());
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        EXPECT_NEAR(image.pixels[i], ramp(16, 8)[i], 6);
}

TEST(Images, DamagedOnesAreErrors) {
    const std::string png = make_png(20, 20, ramp(20, 20));
    const std::string jpeg = make_jpeg(20, 20, ramp(20, 20));
    EXPECT_EQ(error_of([&] { decode_image(bytes_of(png.substr(0, 60)), "a"); }).code(),
              ErrorCode::kInvalidInput);
    EXPECT_EQ(error_of([&] { decode_image(bytes_of(jpeg.substr(0, 30)), "a"); }).code(),
              ErrorCode::kInvalidInput);
    EXPECT_EQ(error_of([&] { decode_image(bytes_of("GIF89a"), "a.gif"); }).code(),
              ErrorCode::kUnsupported);
    EXPECT_EQ(error_of([&] { decode_image({}, "a"); }).code(), ErrorCode::kUnsupported);
}

TEST(Images, SizesThatTheBytesCannotHoldAreErrors) {
    std::string png = make_png(20, 20, ramp(20, 20));
    png[18] = '\x40';  // 16404 texels wide
    png[22] = '\x20';  // 8212 high; the checksum is wrong, too
    const ErrorCode code = error_of([&] { decode_image(bytes_of(png), "a"); }).code();
    EXPECT_EQ(code, ErrorCode::kInvalidInput);
    png[17] = '\x7f';
    EXPECT_NE(error_of([&] { decode_image(bytes_of(png), "a"); }).code(), ErrorCode::kOutput);
}

}  // namespace
}  // namespace pointbake::test
