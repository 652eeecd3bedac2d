// PNG by libspng, JPEG by libjpeg-turbo, WebP by libwebp. Sizes that a header promises are checked
// against what the bytes can hold before anything is allocated.
#include "io/image_io.h"

#include <spng.h>
#include <turbojpeg.h>
#include <webp/decode.h>

#include <cstring>
#include <memory>
#include <string_view>

#include "core/mapped_file.h"
#include "core/message.h"

namespace pointbake {
namespace {

constexpr std::uint64_t kMaxTexels = std::uint64_t{1} << 28;  // 16384 x 16384
constexpr std::uint64_t kMaxDeflateRatio = 1032;              // [RFC1951]: 258 bytes from 2 bits

// No painting of more texels than this is packed so small.
constexpr std::uint64_t kSureTexels = std::uint64_t{1} << 24, kMostPerByte = 64;

void check_size(std::uint64_t width, std::uint64_t height, const std::string& name) {
    if (width * height > kMaxTexels)
        fail(ErrorCode::kLimit, "{}: {} x {} texels; at most 2^28 are read", name, width, height);
}

void check_packing(std::uint64_t width, std::uint64_t height, std::size_t num_bytes,
                   const std::string& name) {
    if (width * height <= kSureTexels || width * height / kMostPerByte <= num_bytes) return;
    fail(ErrorCode::kLimit,
         "{}: {} x {} texels from {} bytes; beyond 2^24 at most {} per byte are read", name, width,
         height, num_bytes, kMostPerByte);
}

Image make_image(std::uint32_t width, std::uint32_t height) {
    Image image;
    image.width = static_cast<int>(width);
    image.height = static_cast<int>(height);
    image.num_channels = 3;
    image.pixels.resize(image.num_texels() * 3);
    return image;
}

Image decode_png(std::span<const std::byte> bytes, const std::string& name) {
    const std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)> context(spng_ctx_new(0),
                                                                      &spng_ctx_free);
    const auto check = [&](int error) {
        if (error != 0)
            fail(ErrorCode::kInvalidInput, "{}: damaged PNG: {}", name, spng_strerror(error));
    };
    check(spng_set_png_buffer(context.get(), bytes.data(), bytes.size()));
    check(spng_set_crc_action(context.get(), SPNG_CRC_USE, SPNG_CRC_USE));
    spng_ihdr header{};
    check(spng_get_ihdr(context.get(), &header));
    check_size(header.width, header.height, name);
    std::size_t raw_bytes = 0;
    check(spng_decoded_image_size(context.get(), SPNG_FMT_PNG, &raw_bytes));
    if (raw_bytes / kMaxDeflateRatio > bytes.size())
        fail(ErrorCode::kInvalidInput, "{}: damaged PNG: {} bytes cannot hold {} x {} texels", name,
             bytes.size(), header.width, header.height);
    check_packing(header.width, header.height, bytes.size(), name);
    Image image = make_image(header.width, header.height);
    check(spng_decode_image(context.get(), image.pixels.data(), image.pixels.size(), SPNG_FMT_RGB8,
                            0));
    return image;
}

Image decode_jpeg(std::span<const std::byte> bytes, const std::string& name, Maker maker) {
    const std::unique_ptr<void, int (*)(void*)> decoder(tjInitDecompress(), &tjDestroy);
    const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
    const auto fail_here = [&] {
        fail(ErrorCode::kInvalidInput, "{}: damaged JPEG: {}", name, tjGetErrorStr2(decoder.get()));
    };
    int width = 0, height = 0, subsampling = 0, colorspace = 0;
    if (tjDecompressHeader3(decoder.get(), data, bytes.size(), &width, &height, &subsampling,
                            &colorspace) != 0)
        fail_here();
    if (colorspace == TJCS_CMYK || colorspace == TJCS_YCCK)
        fail(ErrorCode::kUnsupported, "{}: a CMYK JPEG; RGB and grey ones are read", name);
    const auto num_columns = static_cast<std::uint32_t>(width);
    const auto num_rows = static_cast<std::uint32_t>(height);
    check_size(num_columns, num_rows, name);
    if (maker == Maker::kStranger) check_packing(num_columns, num_rows, bytes.size(), name);
    Image image = make_image(num_columns, num_rows);
    // Warnings (a file that is cut off in its last rows) leave a usable image.
    if (tjDecompress2(decoder.get(), data, bytes.size(), image.pixels.data(), width, 0, height,
                      TJPF_RGB, TJFLAG_ACCURATEDCT) != 0 &&
        tjGetErrorCode(decoder.get()) == TJERR_FATAL)
        fail_here();
    return image;
}

Image decode_webp(std::span<const std::byte> bytes, const std::string& name, Maker maker) {
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    int width = 0, height = 0;
    if (WebPGetInfo(data, bytes.size(), &width, &height) == 0)
        fail(ErrorCode::kInvalidInput, "{}: damaged WebP: its header cannot be read", name);
    const auto num_columns = static_cast<std::uint32_t>(width);
    const auto num_rows = static_cast<std::uint32_t>(height);
    check_size(num_columns, num_rows, name);
    if (maker == Maker::kStranger) check_packing(num_columns, num_rows, bytes.size(), name);
    Image image = make_image(num_columns, num_rows);
    if (WebPDecodeRGBInto(data, bytes.size(), image.pixels.data(), image.pixels.size(),
                          3 * width) == nullptr)
        fail(ErrorCode::kInvalidInput, "{}: damaged WebP, or an animated one", name);
    return image;
}

}  // namespace

Image decode_image(std::span<const std::byte> bytes, const std::string& name, Maker maker) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.starts_with("\x89PNG")) return decode_png(bytes, name);
    if (text.starts_with("\xff\xd8\xff")) return decode_jpeg(bytes, name, maker);
    if (text.starts_with("RIFF") && text.substr(0, 12).ends_with("WEBP"))
        return decode_webp(bytes, name, maker);
    fail(ErrorCode::kUnsupported,
         "{}: neither PNG nor JPEG nor WebP, which are the images that are read", name);
}

Image read_image(const std::filesystem::path& path) {
    const MappedFile file(path);
    return decode_image(file.bytes(), path.string());
}

}  // namespace pointbake
