// Based on [PNG03]: per row the filter with the least sum of absolute
// differences (its section 12.8). Bands of rows are filtered and compressed on their own, in
// parallel; each is one IDAT chunk of a common zlib stream.
#include "write/png.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "core/atomic_file.h"
#include "core/message.h"
#include "core/parallel.h"
#include "pointbake/write.h"
#include "write/deflate.h"

namespace pointbake {
namespace {

// Bytes of a band: a new band forgets the 32 KiB that matches can reach back to, 3 % of it.
constexpr std::size_t kBandBytes = std::size_t{1} << 20;

using Byte = std::uint8_t;

enum Filter : Byte { kNone, kSub, kUp, kAverage, kPaeth };
constexpr std::size_t kNumFilters = 5;

/// The neighbour that a + b - c is nearest to; ties: a, b, c. Written without branches.
inline Byte paeth(Byte left, Byte up, Byte corner) {
    const int to_left = std::abs(up - corner);
    const int to_up = std::abs(left - corner);
    const int to_corner = std::abs(left + up - 2 * corner);
    const Byte up_or_corner = to_up <= to_corner ? up : corner;
    return to_left <= to_up && to_left <= to_corner ? left : up_or_corner;
}

/// A row's bytes behind `bpp` zeros, so that the pixel to the left is always there.
struct Row {
    const Byte* bytes;
    std::size_t size, bpp;
    const Byte* left() const { return bytes - bpp; }
};

void apply(Filter filter, const Row& row, const Row& above, Byte* out) {
    const Byte* const x = row.bytes;
    const Byte* const a = row.left();
    const Byte* const b = above.bytes;
    const Byte* const c = above.left();
    const std::size_t n = row.size;
    switch (filter) {
        case kNone:
            std::memcpy(out, x, n);
            break;
        case kSub:
            for (std::size_t i = 0; i < n; ++i) out[i] = static_cast<Byte>(x[i] - a[i]);
            break;
        case kUp:
            for (std::size_t i = 0; i < n; ++i) out[i] = static_cast<Byte>(x[i] - b[i]);
            break;
        case kAverage:
            for (std::size_t i = 0; i < n; ++i)
                out[i] = static_cast<Byte>(x[i] - ((a[i] + b[i]) >> 1));
            break;
        case kPaeth:
            for (std::size_t i = 0; i < n; ++i)
                out[i] = static_cast<Byte>(x[i] - paeth(a[i], b[i], c[i]));
            break;
    }
}

/// Sum of the bytes' absolute values, read as signed.
std::uint64_t cost(const Byte* bytes, std::size_t n) {
    std::uint64_t sum = 0;
    for (std::size_t begin = 0; begin < n; begin += 4096) {  // 32-bit sums are vectorised better
        std::uint32_t part = 0;
        const std::size_t end = std::min(n, begin + 4096);
        for (std::size_t i = begin; i < end; ++i) {
            const unsigned v = bytes[i];
            part += std::min(v, 256U - v);
        }
        sum += part;
    }
    return sum;
}

/// Filters the rows of one band.
class BandFilter {
 public:
    explicit BandFilter(const Image& image)
        : image_(image),
          bpp_(static_cast<std::size_t>(image.num_channels)),
          row_bytes_(static_cast<std::size_t>(image.width) * bpp_),
          current_(bpp_ + row_bytes_),
          previous_(bpp_ + row_bytes_),
          candidate_(row_bytes_),
          best_(row_bytes_) {}

    std::vector<std::byte> run(std::size_t begin, std::size_t end) {
        std::vector<std::byte> out((end - begin) * (1 + row_bytes_));
        if (begin > 0) load(previous_, begin - 1);
        for (std::size_t y = begin; y < end; ++y) {
            load(current_, y);
            const Filter filter = choose();
            std::byte* const to = out.data() + (y - begin) * (1 + row_bytes_);
            to[0] = static_cast<std::byte>(filter);
            std::memcpy(to + 1, best_.data(), row_bytes_);
            std::swap(current_, previous_);
        }
        return out;
    }

 private:
    void load(std::vector<Byte>& row, std::size_t y) const {
        std::memcpy(row.data() + bpp_, image_.pixels.data() + y * row_bytes_, row_bytes_);
    }

    /// Leaves the best filter's bytes in best_.
    Filter choose() {
        const Row row{current_.data() + bpp_, row_bytes_, bpp_};
        const Row above{previous_.data() + bpp_, row_bytes_, bpp_};
        Filter chosen = kNone;
        std::uint64_t least = ~std::uint64_t{0};
        for (std::size_t f = 0; f < kNumFilters; ++f) {
            apply(static_cast<Filter>(f), row, above, candidate_.data());
            const std::uint64_t sum = cost(candidate_.data(), row_bytes_);
            if (sum >= least) continue;
            least = sum;
            chosen = static_cast<Filter>(f);
            std::swap(candidate_, best_);
        }
        return chosen;
    }

    const Image& image_;
    std::size_t bpp_, row_bytes_;
    std::vector<Byte> current_, previous_, candidate_, best_;
};

void append_u32(std::vector<std::byte>& out, std::uint32_t v) {
    for (int shift = 24; shift >= 0; shift -= 8)
        out.push_back(static_cast<std::byte>(v >> shift & 0xffU));
}

/// A chunk: length, type, data, CRC-32 of type and data.
void append_chunk(std::vector<std::byte>& out, std::string_view type,
                  std::span<const std::byte> data) {
    append_u32(out, static_cast<std::uint32_t>(data.size()));
    const std::size_t begin = out.size();
    for (const char c : type) out.push_back(static_cast<std::byte>(c));
    out.insert(out.end(), data.begin(), data.end());
    append_u32(out, libdeflate_crc32(0, out.data() + begin, out.size() - begin));
}

void check_image(const Image& image) {
    if (image.width < 1 || image.height < 1 || image.num_channels < 1 || image.num_channels > 4)
        fail(ErrorCode::kInvalidInput,
             "an image of {} x {} texels with {} channels cannot be written: at least 1 x 1 and 1 "
             "to 4 channels are needed",
             image.width, image.height, image.num_channels);
    const std::size_t expected = image.num_texels() * static_cast<std::size_t>(image.num_channels);
    if (image.pixels.size() != expected)
        fail(ErrorCode::kInvalidInput,
             "an image of {} x {} texels with {} channels holds {} bytes instead of {}",
             image.width, image.height, image.num_channels, image.pixels.size(), expected);
}

void append_header(std::vector<std::byte>& out, const Image& image) {
    constexpr std::array<unsigned char, 8> kSignature = {0x89, 'P',  'N',  'G',
                                                         '\r', '\n', 0x1a, '\n'};
    constexpr std::array<std::uint8_t, 5> kColorTypes = {0, 0, 4, 2, 6};  // by number of channels
    for (const unsigned char c : kSignature) out.push_back(static_cast<std::byte>(c));
    std::vector<std::byte> data;
    append_u32(data, static_cast<std::uint32_t>(image.width));
    append_u32(data, static_cast<std::uint32_t>(image.height));
    const std::uint8_t color = kColorTypes[static_cast<std::size_t>(image.num_channels)];
    // Depth 8; deflate, adaptive filters, not interlaced.
    for (const std::uint8_t v :
         {std::uint8_t{8}, color, std::uint8_t{0}, std::uint8_t{0}, std::uint8_t{0}})
        data.push_back(static_cast<std::byte>(v));
    append_chunk(out, "IHDR", data);
}

/// Filters and compresses bands in parallel; the zlib header goes before the first and the checksum
/// behind the last.
std::vector<std::vector<std::byte>> compress_bands(const Image& image, const Context& context) {
    const auto height = static_cast<std::size_t>(image.height);
    const std::size_t row_bytes = 1 + image.pixels.size() / height;
    const std::size_t rows_per_band = std::max<std::size_t>(1, kBandBytes / row_bytes);
    std::vector<DeflatedPiece> pieces((height + rows_per_band - 1) / rows_per_band);
    parallel_for(context, height, rows_per_band, [&](std::size_t begin, std::size_t end) {
        pieces[begin / rows_per_band] =
            deflate_piece(BandFilter(image).run(begin, end), end == height);
    });
    std::uint32_t adler = 1;
    std::vector<std::vector<std::byte>> bands;
    for (DeflatedPiece& piece : pieces) {
        adler = adler32_combine(adler, piece.adler, piece.num_raw);
        bands.push_back(std::move(piece.bytes));
    }
    bands.front().insert(bands.front().begin(), {std::byte{0x78}, std::byte{0x9c}});  // RFC 1950
    append_u32(bands.back(), adler);
    return bands;
}

}  // namespace

std::vector<std::byte> encode_png(const Image& image, const Context& context) {
    check_image(image);
    std::vector<std::vector<std::byte>> bands = compress_bands(image, context);
    std::size_t num_bytes = 64;  // signature, IHDR and IEND
    for (const auto& band : bands) num_bytes += band.size() + 12;
    std::vector<std::byte> out;
    out.reserve(num_bytes);
    append_header(out, image);
    for (auto& band : bands) {
        append_chunk(out, "IDAT", band);
        band = {};
    }
    append_chunk(out, "IEND", {});
    return out;
}

void write_png(const Image& image, const std::filesystem::path& path, const Context& context) {
    const std::vector<std::byte> bytes = encode_png(image, context);
    AtomicFile file(path);
    file.write(bytes);
    file.commit();
}

}  // namespace pointbake
