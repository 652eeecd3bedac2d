// A z-buffer with 3 x 3 samples per pixel, in bands of rows that are drawn independently.
#include "render/canvas.h"

#include <algorithm>
#include <cmath>

#include "core/color.h"
#include "core/message.h"
#include "core/parallel.h"

namespace pointbake::render {
namespace {

// Pixel rows per band: small enough to stay in the cache (512 x 16 x 9 samples of 8 bytes), large
// enough that few primitives are drawn twice.
constexpr int kBandRows = 16;
constexpr int kMaxSide = 16384;

std::pair<int, int> clipped_range(double low, double high, int count) {
    // Sample k lies at (k + 0.5) / kSuper; compare as doubles so that far places cannot overflow.
    const double first = std::ceil(low * kSuper - 0.5), last = std::floor(high * kSuper - 0.5);
    const double limit = count;
    return {static_cast<int>(std::clamp(first, 0.0, limit)),
            static_cast<int>(std::clamp(last + 1.0, 0.0, limit))};
}

// Which primitives touch which band, in ascending order.
std::vector<std::vector<Index>> sort_into_bands(std::span<const RowRange> primitives,
                                                int num_bands) {
    std::vector<std::vector<Index>> bands(static_cast<std::size_t>(num_bands));
    const auto band_of = [&](float row) {
        return static_cast<int>(
            std::clamp(std::floor(row / kBandRows), -1.0F, static_cast<float>(num_bands)));
    };
    for (Index k = 0; k < primitives.size(); ++k) {
        const int first = std::max(0, band_of(primitives[k].low));
        const int last = std::min(num_bands - 1, band_of(primitives[k].high));
        for (int b = first; b <= last; ++b) bands[static_cast<std::size_t>(b)].push_back(k);
    }
    return bands;
}

// Mean of a pixel's samples in linear light. Pixels that nothing covers are exactly the background.
void resolve(const Band& band, bool is_transparent, Image& image) {
    const Vec3f background =
        to_linear(rgb16_from_8bit(kBackground[0], kBackground[1], kBackground[2]));
    const auto channels = static_cast<std::size_t>(image.num_channels);
    for (int row = 0; row < band.num_rows; ++row)
        for (int column = 0; column < band.width; ++column) {
            Vec3f sum;
            int num_covered = 0;
            for (int s = 0; s < kSuper * kSuper; ++s) {
                const std::size_t k =
                    band.sample(row * kSuper + s / kSuper, column * kSuper + s % kSuper);
                if (band.id[k] == kInvalidIndex) continue;
                sum += band.color[k];
                ++num_covered;
            }
            const int num_samples = is_transparent ? num_covered : kSuper * kSuper;
            if (!is_transparent) sum += background * static_cast<float>(num_samples - num_covered);
            std::uint8_t* const pixel =
                &image.pixels[channels * (static_cast<std::size_t>(band.first_row + row) *
                                              static_cast<std::size_t>(band.width) +
                                          static_cast<std::size_t>(column))];
            if (is_transparent)
                pixel[3] = static_cast<std::uint8_t>(255 * num_covered / (kSuper * kSuper));
            for (std::size_t k = 0; k < 3; ++k)
                pixel[k] = num_covered == 0
                               ? kBackground[k]
                               : linear_to_srgb8(sum[k] / static_cast<float>(num_samples));
        }
}

}  // namespace

Camera::Camera(const View& view, std::span<const Vec3d> positions) {
    if (view.width < 1 || view.height < 1 || view.width > kMaxSide || view.height > kMaxSide)
        fail(ErrorCode::kInvalidOption, "a picture of {} x {} pixels: sides of 1 to {} are drawn",
             view.width, view.height, kMaxSide);
    toward = normalized(view.direction);
    right = normalized(cross(view.up, toward));
    if (!(squared_length(right) > 0.0) || !is_finite(right) || !(view.zoom > 0.0))
        fail(ErrorCode::kInvalidOption,
             "no such view: the direction must not be zero nor along `up`, the zoom positive");
    up = cross(toward, right);
    Box box = view.box;
    if (box.is_empty())
        for (const Vec3d& p : positions) box.extend(p);
    const double diagonal = box.diagonal() > 0.0 ? box.diagonal() : 1.0;
    origin = box.center() + view.center * diagonal;
    scale = std::min(view.width, view.height) * view.zoom / diagonal;
    half_width = 0.5 * view.width;
    half_height = 0.5 * view.height;
}

std::pair<int, int> Band::rows_between(double low, double high) const {
    return clipped_range(low - first_row, high - first_row, sample_rows());
}
std::pair<int, int> Band::columns_between(double low, double high) const {
    return clipped_range(low, high, sample_columns());
}

Image draw(const View& view, std::span<const RowRange> primitives, const BandPainter& paint,
           const Context& context) {
    Image image{view.width, view.height, view.is_transparent ? 4 : 3, {}};
    image.pixels.resize(static_cast<std::size_t>(image.num_channels) * image.num_texels());
    const int num_bands = (view.height + kBandRows - 1) / kBandRows;
    const std::vector<std::vector<Index>> bands = sort_into_bands(primitives, num_bands);
    parallel_for(context, bands.size(), 1, [&](std::size_t b, std::size_t) {
        Band band;
        band.first_row = static_cast<int>(b) * kBandRows;
        band.num_rows = std::min(kBandRows, view.height - band.first_row);
        band.width = view.width;
        const auto count = static_cast<std::size_t>(band.sample_rows()) *
                           static_cast<std::size_t>(band.sample_columns());
        band.depth.assign(count, -HUGE_VALF);
        band.id.assign(count, kInvalidIndex);
        band.color.resize(count);
        paint(bands[b], band);
        resolve(band, view.is_transparent, image);
    });
    return image;
}

BandPainter opaque(Rasterizer rasterize, Shader shade) {
    return [rasterize = std::move(rasterize), shade = std::move(shade)](
               std::span<const Index> primitives, Band& band) {
        for (const Index k : primitives) rasterize(k, band);
        for (int row = 0; row < band.sample_rows(); ++row)
            for (int column = 0; column < band.sample_columns(); ++column) {
                const std::size_t k = band.sample(row, column);
                if (band.id[k] != kInvalidIndex)
                    band.color[k] = shade(band.id[k], band.sample_x(column), band.sample_y(row));
            }
    };
}

}  // namespace pointbake::render
