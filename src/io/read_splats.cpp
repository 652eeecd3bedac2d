// .splat: position and sigmas as three floats each, red green blue opacity and a quaternion w x y z
// as a byte each. .spz: one array after the other; versions 1 to 3 are gzip as a whole, version 4
// has a zstd stream per array, whose sizes stand behind its header.
#include "io/read_splats.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/message.h"
#include "core/parallel.h"
#include "io/finish_cloud.h"
#include "io/input_file.h"
#include "io/number_type.h"
#include "io/splats.h"

namespace pointbake {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kGrain = 8192;
constexpr double kSqrtHalf = 0.70710678118654752;

double byte_at(Bytes bytes, std::size_t i) {
    return static_cast<double>(std::to_integer<int>(bytes[i]));
}

/// Room for n splats; their bytes have been seen.
struct SplatRows {
    PointRows points;
    SplatShapes shapes;

    SplatRows(std::uint64_t num_splats, const std::string& name) {
        if (num_splats >= kInvalidIndex)
            fail(ErrorCode::kLimit, "{}: {} splats; at most {} are read", name, num_splats,
                 kInvalidIndex - 1);
        const auto n = static_cast<std::size_t>(num_splats);
        points.cloud.positions.resize(n);
        points.cloud.colors.resize(n);
        shapes.sigmas.resize(n);
        shapes.rotations.resize(n);
        shapes.opacities.resize(n);
    }
    std::size_t size() const { return shapes.sigmas.size(); }
};

LoadResult finish(SplatRows rows, std::string format, const std::string& name,
                  const Context& context) {
    make_surfels(rows.points, rows.shapes, context);
    report_progress(context, "load", 0.5);
    LoadResult result =
        finish_cloud(std::move(rows.points), std::move(format), name, context).result;
    report_progress(context, "load", 1.0);
    return result;
}

void read_splat_row(const std::byte* from, std::size_t i, SplatRows& rows) {
    const auto triple = [&](std::size_t at) {
        return Vec3f{load_value<float>(from + at), load_value<float>(from + at + 4),
                     load_value<float>(from + at + 8)};
    };
    const Bytes bytes(from + 24, 8);
    rows.points.cloud.positions[i] = vec_cast<double>(triple(0));
    rows.shapes.sigmas[i] = triple(12);
    rows.points.cloud.colors[i] =
        color_of_unit(Vec3d{byte_at(bytes, 0), byte_at(bytes, 1), byte_at(bytes, 2)} / 255.0);
    rows.shapes.opacities[i] = static_cast<float>(byte_at(bytes, 3) / 255.0);
    for (std::size_t k = 0; k < 4; ++k)
        rows.shapes.rotations[i][k] = static_cast<float>(byte_at(bytes, 4 + k) / 128.0 - 1.0);
}

struct SpzHeader {
    std::uint32_t version = 0;
    std::uint32_t num_splats = 0;
    int fraction_bits = 0;
};

/// The arrays of a file, each as long as its splats need.
struct SpzArrays {
    Bytes positions, opacities, colors, scales, rotations;
};
constexpr std::size_t kNumArrays = 5;

std::array<std::size_t, kNumArrays> bytes_per_splat(const SpzHeader& header) {
    return {header.version == 1 ? 6U : 9U, 1, 3, 3, header.version < 3 ? 3U : 4U};
}

SpzHeader read_spz_header(Bytes bytes, const std::string& name) {
    constexpr std::size_t kBytes = 16;
    if (bytes.size() < kBytes)
        fail(ErrorCode::kInvalidInput, "{}: the SPZ header is cut off at byte {}", name,
             bytes.size());
    SpzHeader header;
    header.version = load_value<std::uint32_t>(bytes.data() + 4);
    header.num_splats = load_value<std::uint32_t>(bytes.data() + 8);
    header.fraction_bits = std::to_integer<int>(bytes[13]);
    constexpr std::uint32_t kNewest = 4;
    if (header.version < 1 || header.version > kNewest)
        fail(ErrorCode::kUnsupported, "{}: SPZ of version {}; 1 to {} are read", name,
             header.version, kNewest);
    constexpr int kMostBits = 24;
    if (header.fraction_bits > kMostBits)
        fail(ErrorCode::kInvalidInput, "{}: byte 13: {} fractional bits; at most {} make sense",
             name, header.fraction_bits, kMostBits);
    if (header.num_splats == 0) fail(ErrorCode::kEmpty, "{}: the file holds 0 points", name);
    return header;
}

SpzArrays as_arrays(const std::array<Bytes, kNumArrays>& parts) {
    return {parts[0], parts[1], parts[2], parts[3], parts[4]};
}

SpzArrays arrays_in_a_row(Bytes bytes, const SpzHeader& header, const std::string& name) {
    constexpr std::size_t kHeaderBytes = 16;
    std::array<Bytes, kNumArrays> parts;
    Bytes rest = bytes.subspan(kHeaderBytes);
    for (std::size_t k = 0; k < kNumArrays; ++k) {
        const std::size_t size = bytes_per_splat(header)[k] * header.num_splats;
        if (size > rest.size())
            fail(ErrorCode::kInvalidInput,
                 "{}: the header promises {} splats, but their data end at byte {}: the file is "
                 "cut off, or the header is wrong",
                 name, header.num_splats, bytes.size());
        parts[k] = rest.first(size);
        rest = rest.subspan(size);
    }
    return as_arrays(parts);
}

/// Unpacks the streams of version 4 into `buffers`.
SpzArrays arrays_of_streams(Bytes bytes, const SpzHeader& header, const std::string& name,
                            const Context& context, std::array<ByteBuffer, kNumArrays>& buffers) {
    constexpr std::size_t kFixedBytes = 20, kEntryBytes = 16;
    const auto fail_short = [&] {
        fail(ErrorCode::kInvalidInput, "{}: the table of streams is cut off or wrong", name);
    };
    if (bytes.size() < kFixedBytes) fail_short();
    const auto num_streams = std::to_integer<std::size_t>(bytes[15]);
    const std::size_t table = load_value<std::uint32_t>(bytes.data() + 16);
    if (num_streams < kNumArrays || table > bytes.size() ||
        num_streams * kEntryBytes > bytes.size() - table)
        fail_short();
    std::array<Bytes, kNumArrays> parts;
    std::size_t begin = table + num_streams * kEntryBytes;
    for (std::size_t k = 0; k < kNumArrays; ++k) {
        const std::byte* const entry = bytes.data() + table + k * kEntryBytes;
        const auto num_packed = load_value<std::uint64_t>(entry);
        const std::uint64_t wanted = std::uint64_t{bytes_per_splat(header)[k]} * header.num_splats;
        if (num_packed > bytes.size() - begin) fail_short();
        buffers[k] =
            unpack_zstd(bytes.subspan(begin, static_cast<std::size_t>(num_packed)), name, context);
        parts[k] = buffers[k].bytes();
        if (parts[k].size() != wanted)
            fail(ErrorCode::kInvalidInput,
                 "{}: byte {}: {} splats need {} bytes of the stream, but {} are there", name,
                 begin, header.num_splats, wanted, parts[k].size());
        begin += static_cast<std::size_t>(num_packed);
    }
    return as_arrays(parts);
}

/// IEEE half precision.
double half_at(const std::byte* from) {
    const auto bits = load_value<std::uint16_t>(from);
    const int exponent = bits >> 10 & 31;
    const double mantissa = bits & 1023;
    const double sign = bits >> 15 == 0 ? 1.0 : -1.0;
    if (exponent == 31) return std::numeric_limits<double>::quiet_NaN();
    if (exponent == 0) return sign * std::ldexp(mantissa, -24);
    return sign * std::ldexp(1024.0 + mantissa, exponent - 25);
}

Vec3d spz_position(const SpzHeader& header, const std::byte* from) {
    Vec3d p;
    for (std::size_t k = 0; k < 3; ++k) {
        if (header.version == 1) {
            p[k] = half_at(from + 2 * k);
            continue;
        }
        // 24 bits with a sign
        auto value = std::to_integer<std::int32_t>(from[3 * k]) |
                     std::to_integer<std::int32_t>(from[3 * k + 1]) << 8 |
                     std::to_integer<std::int32_t>(from[3 * k + 2]) << 16;
        if (value >= 1 << 23) value -= 1 << 24;
        p[k] = std::ldexp(static_cast<double>(value), -header.fraction_bits);
    }
    return p;
}

/// w, x, y, z; the file has x, y, z and perhaps w.
std::array<float, 4> spz_rotation(const SpzHeader& header, const std::byte* from) {
    std::array<double, 4> q{};  // x, y, z, w
    double squares = 0.0;
    std::size_t left_out = 3;
    if (header.version < 3) {
        for (std::size_t k = 0; k < 3; ++k) q[k] = std::to_integer<int>(from[k]) / 127.5 - 1.0;
    } else {
        // Which is the largest, and the three others with ten bits each, the last one lowest
        auto bits = load_value<std::uint32_t>(from);
        left_out = bits >> 30;
        for (std::size_t k = 4; k-- > 0;) {
            if (k == left_out) continue;
            const double size = kSqrtHalf * static_cast<double>(bits & 511U) / 511.0;
            q[k] = (bits >> 9 & 1U) != 0 ? -size : size;
            bits >>= 10;
        }
    }
    for (const double v : q) squares += v * v;
    q[left_out] = std::sqrt(std::max(0.0, 1.0 - squares));
    return {static_cast<float>(q[3]), static_cast<float>(q[0]), static_cast<float>(q[1]),
            static_cast<float>(q[2])};
}

void read_spz_row(const SpzHeader& header, const SpzArrays& arrays, std::size_t i,
                  SplatRows& rows) {
    constexpr double kColorScale = 0.15, kStepsPerLog = 16.0, kLeastLog = -10.0;
    const std::array<std::size_t, kNumArrays> sizes = bytes_per_splat(header);
    rows.points.cloud.positions[i] = spz_position(header, arrays.positions.data() + i * sizes[0]);
    rows.shapes.opacities[i] = static_cast<float>(byte_at(arrays.opacities, i) / 255.0);
    Vec3d harmonic;
    Vec3f sigmas;
    for (std::size_t k = 0; k < 3; ++k) {
        harmonic[k] = (byte_at(arrays.colors, 3 * i + k) / 255.0 - 0.5) / kColorScale;
        sigmas[k] = static_cast<float>(
            portable_exp(byte_at(arrays.scales, 3 * i + k) / kStepsPerLog + kLeastLog));
    }
    rows.points.cloud.colors[i] = color_of_harmonic(harmonic);
    rows.shapes.sigmas[i] = sigmas;
    rows.shapes.rotations[i] = spz_rotation(header, arrays.rotations.data() + i * sizes[4]);
}

}  // namespace

bool is_spz(Bytes bytes) {
    return bytes.size() >= 4 && load_value<std::uint32_t>(bytes.data()) == 0x5053474eU;  // NGSP
}

LoadResult read_spz(Bytes bytes, const std::filesystem::path& path, const Context& context) {
    const std::string name = path.string();
    const SpzHeader header = read_spz_header(bytes, name);
    std::array<ByteBuffer, kNumArrays> buffers;
    const SpzArrays arrays = header.version == 4
                                 ? arrays_of_streams(bytes, header, name, context, buffers)
                                 : arrays_in_a_row(bytes, header, name);
    SplatRows rows(header.num_splats, name);
    parallel_for(context, rows.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) read_spz_row(header, arrays, i, rows);
    });
    return finish(std::move(rows), fmt::format("SPZ {}", header.version), name, context);
}

LoadResult read_splat(Bytes bytes, const std::filesystem::path& path, const Context& context) {
    constexpr std::size_t kBytes = 32;
    const std::string name = path.string();
    if (bytes.size() % kBytes != 0)
        fail(ErrorCode::kInvalidInput,
             "{}: {} bytes are not a whole number of splats of {} bytes each: the file is cut off, "
             "or it is no .splat",
             name, bytes.size(), kBytes);
    SplatRows rows(bytes.size() / kBytes, name);
    parallel_for(context, rows.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            read_splat_row(bytes.data() + i * kBytes, i, rows);
    });
    return finish(std::move(rows), "splat", name, context);
}

}  // namespace pointbake
