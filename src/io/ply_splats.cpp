// Positions and sizes have 11, 10 and 11 bits; rotations two for the largest component and ten for
// each of the others, in the order w, x, y, z; colours and opacity eight each.
#include "io/ply_splats.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/message.h"
#include "core/parallel.h"
#include "io/splats.h"

namespace pointbake {
namespace {

constexpr std::size_t kChunkSplats = 256;
constexpr std::size_t kGrain = 8192;
constexpr double kSqrt2 = 1.4142135623730951;

constexpr std::array<std::string_view, 4> kPacked{"packed_position", "packed_rotation",
                                                  "packed_scale", "packed_color"};
constexpr std::array<std::string_view, 12> kBounds{
    "min_x",       "min_y",       "min_z",       "max_x",       "max_y",       "max_z",
    "min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z"};
// Files of the first version have none: colours are from 0 to 1.
constexpr std::array<std::string_view, 6> kColorBounds{"min_r", "min_g", "min_b",
                                                       "max_r", "max_g", "max_b"};

/// Columns of an element by name, each with all rows.
template <std::size_t N>
std::array<std::vector<double>, N> read_columns(const PlyBody& body, const PlyHeader& header,
                                                std::size_t element,
                                                const std::array<std::string_view, N>& names,
                                                const std::string& path, const Context& context) {
    const PlyElement& e = header.elements[element];
    std::vector<std::size_t> properties;
    for (const std::string_view name : names) {
        const auto found = e.find(name);
        if (!found || e.properties[*found].is_list())
            fail(ErrorCode::kInvalidInput,
                 "{}: element '{}' has no scalar property '{}', which compressed splats need", path,
                 e.name, name);
        properties.push_back(*found);
    }
    std::array<std::vector<double>, N> columns;
    for (std::vector<double>& column : columns) column.resize(static_cast<std::size_t>(e.count));
    body.read(element, properties, context, [&](const PlyBlock& block) {
        for (std::size_t k = 0; k < N; ++k)
            std::copy(block.columns[k].values.begin(), block.columns[k].values.end(),
                      columns[k].begin() + static_cast<std::ptrdiff_t>(block.first_row));
    });
    return columns;
}

std::uint32_t bits_of(double value) {
    return value >= 0.0 && value <= 4294967295.0 ? static_cast<std::uint32_t>(value) : 0U;
}

/// `width` bits from `shift` on, as a number from 0 to 1.
double unit_at(std::uint32_t bits, int shift, int width) {
    const std::uint32_t most = (1U << width) - 1U;
    return static_cast<double>(bits >> shift & most) / static_cast<double>(most);
}

Vec3d unpack_11_10_11(std::uint32_t bits) {
    return {unit_at(bits, 21, 11), unit_at(bits, 11, 10), unit_at(bits, 0, 11)};
}

std::array<float, 4> unpack_rotation(std::uint32_t bits) {
    std::array<float, 4> q{};
    const std::size_t largest = bits >> 30;
    double squares = 0.0;
    int shift = 20;
    for (std::size_t k = 0; k < 4; ++k) {
        if (k == largest) continue;
        const double value = (unit_at(bits, shift, 10) - 0.5) * kSqrt2;
        q[k] = static_cast<float>(value);
        squares += value * value;
        shift -= 10;
    }
    q[largest] = static_cast<float>(std::sqrt(std::max(0.0, 1.0 - squares)));
    return q;
}

/// Least and most of three values in each chunk.
struct Bounds {
    std::span<const std::vector<double>> columns;  ///< three least, three most

    Vec3d between(std::size_t chunk, Vec3d share) const {
        Vec3d out;
        for (std::size_t k = 0; k < 3; ++k) {
            const double least = columns[k][chunk], most = columns[k + 3][chunk];
            out[k] = least + share[k] * (most - least);
        }
        return out;
    }
};

}  // namespace

bool has_packed_splats(const PlyElement& element) { return element.find(kPacked[0]).has_value(); }

PointRows read_packed_splats(const PlyBody& body, const PlyHeader& header, std::size_t element,
                             const std::string& path, const Context& context) {
    const std::uint64_t count = header.elements[element].count;
    const auto chunk_element = header.find("chunk");
    const std::uint64_t num_chunks = chunk_element ? header.elements[*chunk_element].count : 0;
    if (!chunk_element || *chunk_element > element ||
        num_chunks < (count + kChunkSplats - 1) / kChunkSplats)
        fail(ErrorCode::kInvalidInput,
             "{}: {} compressed splats need {} rows of 'chunk' before them, but there are {}", path,
             count, (count + kChunkSplats - 1) / kChunkSplats, num_chunks);
    if (count >= kInvalidIndex)
        fail(ErrorCode::kLimit, "{}: {} splats; at most {} are read", path, count,
             kInvalidIndex - 1);
    const auto packed = read_columns(body, header, element, kPacked, path, context);
    const auto bounds = read_columns(body, header, *chunk_element, kBounds, path, context);
    const bool has_color_bounds = header.elements[*chunk_element].find(kColorBounds[0]).has_value();
    std::array<std::vector<double>, 6> color_bounds;
    if (has_color_bounds)
        color_bounds = read_columns(body, header, *chunk_element, kColorBounds, path, context);

    const auto n = static_cast<std::size_t>(count);
    PointRows points;
    SplatShapes shapes;
    points.cloud.positions.resize(n);
    points.cloud.colors.resize(n);
    shapes.sigmas.resize(n);
    shapes.rotations.resize(n);
    shapes.opacities.resize(n);
    const std::span<const std::vector<double>> all(bounds);
    const Bounds place{all.first(6)}, size{all.subspan(6)}, color{color_bounds};
    parallel_for(context, n, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t chunk = i / kChunkSplats;
            points.cloud.positions[i] =
                place.between(chunk, unpack_11_10_11(bits_of(packed[0][i])));
            shapes.rotations[i] = unpack_rotation(bits_of(packed[1][i]));
            const Vec3d logs = size.between(chunk, unpack_11_10_11(bits_of(packed[2][i])));
            for (std::size_t k = 0; k < 3; ++k)
                shapes.sigmas[i][k] = static_cast<float>(portable_exp(logs[k]));
            const std::uint32_t bits = bits_of(packed[3][i]);
            const Vec3d rgb{unit_at(bits, 24, 8), unit_at(bits, 16, 8), unit_at(bits, 8, 8)};
            points.cloud.colors[i] =
                color_of_unit(has_color_bounds ? color.between(chunk, rgb) : rgb);
            shapes.opacities[i] = static_cast<float>(unit_at(bits, 0, 8));
        }
    });
    make_surfels(points, shapes, context);
    return points;
}

}  // namespace pointbake
