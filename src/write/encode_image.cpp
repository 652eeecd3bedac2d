// JPEG by libjpeg-turbo, WebP by libwebp, each on one thread: the same bytes on every run.
#include "write/encode_image.h"

#include <turbojpeg.h>
#include <webp/encode.h>

#include <cstring>
#include <memory>

#include "core/message.h"
#include "core/parallel.h"
#include "write/png.h"

namespace pointbake {
namespace {

constexpr int kLongestJpegSide = 65500;  // of libjpeg
constexpr int kFullChromaQuality = 90;   // as ImageMagick and libvips have it
constexpr int kLosslessQuality = 100;

std::vector<std::byte> copied(const void* bytes, std::size_t size) {
    std::vector<std::byte> out(size);
    std::memcpy(out.data(), bytes, size);
    return out;
}

std::vector<std::byte> encode_jpeg(const Image& image, int quality) {
    const std::unique_ptr<void, int (*)(void*)> encoder(tjInitCompress(), &tjDestroy);
    unsigned char* bytes = nullptr;
    unsigned long size = 0;
    const int subsampling = quality < kFullChromaQuality ? TJSAMP_420 : TJSAMP_444;
    const int status =
        tjCompress2(encoder.get(), image.pixels.data(), image.width, 0, image.height, TJPF_RGB,
                    &bytes, &size, subsampling, quality, TJFLAG_ACCURATEDCT | TJFLAG_PROGRESSIVE);
    const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(bytes, &tjFree);
    if (status != 0)
        fail(ErrorCode::kOutput, "a JPEG of {} x {} texels cannot be made: {}", image.width,
             image.height, tjGetErrorStr2(encoder.get()));
    return copied(bytes, size);
}

struct WebpOutput {
    WebpOutput() { WebPMemoryWriterInit(&writer); }
    ~WebpOutput() {
        WebPPictureFree(&picture);
        WebPMemoryWriterClear(&writer);
    }
    WebpOutput(const WebpOutput&) = delete;
    WebpOutput& operator=(const WebpOutput&) = delete;

    WebPPicture picture{};
    WebPMemoryWriter writer{};
};

std::vector<std::byte> encode_webp(const Image& image, int quality, const Context& context) {
    WebPConfig config;
    WebpOutput out;
    bool is_made = WebPConfigInit(&config) != 0 && WebPPictureInit(&out.picture) != 0;
    const bool is_lossless = quality >= kLosslessQuality;
    config.lossless = is_lossless ? 1 : 0;
    // Without loss it is not a quality but an effort: the library's default.
    if (!is_lossless) config.quality = static_cast<float>(quality);
    config.use_sharp_yuv = 1;
    out.picture.use_argb = 1;
    out.picture.width = image.width;
    out.picture.height = image.height;
    out.picture.writer = WebPMemoryWrite;
    out.picture.custom_ptr = &out.writer;
    out.picture.user_data = const_cast<Context*>(&context);
    out.picture.progress_hook = [](int, const WebPPicture* picture) {
        return static_cast<const Context*>(picture->user_data)->stop.stop_requested() ? 0 : 1;
    };
    is_made = is_made &&
              WebPPictureImportRGB(&out.picture, image.pixels.data(), 3 * image.width) != 0 &&
              WebPEncode(&config, &out.picture) != 0;
    check_cancelled(context);
    if (!is_made)
        fail(ErrorCode::kOutput, "a WebP of {} x {} texels cannot be made (libwebp's error {})",
             image.width, image.height, static_cast<int>(out.picture.error_code));
    return copied(out.writer.mem, out.writer.size);
}

}  // namespace

void validate(const ImageOptions& options) {
    if (options.quality < 1 || options.quality > 100)
        fail(ErrorCode::kInvalidOption, "texture-quality is {}: 1 to 100 are accepted",
             options.quality);
}

int longest_side(ImageFormat format) {
    return format == ImageFormat::kWebp ? WEBP_MAX_DIMENSION : kLongestJpegSide;
}

std::vector<std::byte> encode_lossy(const Image& image, const ImageOptions& options,
                                    const Context& context) {
    const int longest = longest_side(options.format);
    if (image.width > longest || image.height > longest)
        fail(ErrorCode::kLimit,
             "a page of {} x {} texels is too large for {}: at most {} are possible on a side "
             "(--page-size)",
             image.width, image.height, to_word(options.format), longest);
    return options.format == ImageFormat::kJpeg ? encode_jpeg(image, options.quality)
                                                : encode_webp(image, options.quality, context);
}

std::vector<std::byte> image_file(const Image& image, const Context& context) {
    return image.file.empty() ? encode_png(image, context) : image.file;
}

FileKind file_kind(const Image& image) {
    if (image.file.empty()) return {".png", "image/png"};
    if (image.file[0] == std::byte{0xFF}) return {".jpg", "image/jpeg"};
    return {".webp", "image/webp"};
}

}  // namespace pointbake
