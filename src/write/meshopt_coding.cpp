#include "write/meshopt_coding.h"

#include <meshoptimizer.h>

#include <cmath>
#include <cstdint>
#include <cstring>

#include "core/message.h"

namespace pointbake {
namespace {

/// The extension's EXPONENTIAL filter, with one exponent for all: a number on a grid.
std::vector<std::uint32_t> on_grid(std::span<const std::byte> elements, int exponent) {
    std::vector<std::uint32_t> out(elements.size() / sizeof(float));
    for (std::size_t i = 0; i < out.size(); ++i) {
        float value = 0.0F;
        std::memcpy(&value, elements.data() + i * sizeof(float), sizeof(float));
        const auto mantissa = static_cast<std::int32_t>(
            std::floor(std::ldexp(static_cast<double>(value), -exponent) + 0.5));
        out[i] = (static_cast<std::uint32_t>(exponent) << 24U) |
                 (static_cast<std::uint32_t>(mantissa) & 0xFFFFFFU);
    }
    return out;
}

std::vector<std::byte> cut_to(std::vector<std::byte> bytes, std::size_t size) {
    POINTBAKE_ASSERT(size > 0, "meshoptimizer's bound of a buffer's size is too small");
    bytes.resize(size);
    return bytes;
}

unsigned char* as_chars(std::vector<std::byte>& bytes) {
    return reinterpret_cast<unsigned char*>(bytes.data());
}

}  // namespace

MeshoptView meshopt_indices(std::span<const Index> indices) {
    meshopt_encodeIndexVersion(1);  // the one that the extension knows
    const std::size_t num_vertices = ~Index{0};
    std::vector<std::byte> bytes(meshopt_encodeIndexBufferBound(indices.size(), num_vertices));
    const std::size_t size =
        meshopt_encodeIndexBuffer(as_chars(bytes), bytes.size(), indices.data(), indices.size());
    return {cut_to(std::move(bytes), size), "TRIANGLES", "NONE"};
}

MeshoptView meshopt_attribute(std::span<const std::byte> elements, std::size_t stride,
                              std::optional<int> exponent) {
    meshopt_encodeVertexVersion(0);
    std::vector<std::uint32_t> grid;
    if (exponent) {
        grid = on_grid(elements, *exponent);
        elements = std::as_bytes(std::span(grid));
    }
    const std::size_t count = elements.size() / stride;
    std::vector<std::byte> bytes(meshopt_encodeVertexBufferBound(count, stride));
    const std::size_t size =
        meshopt_encodeVertexBuffer(as_chars(bytes), bytes.size(), elements.data(), count, stride);
    return {cut_to(std::move(bytes), size), "ATTRIBUTES", exponent ? "EXPONENTIAL" : "NONE"};
}

void reorder_in_place(MeshPart& part) {
    const std::size_t num_vertices = part.corners.size();
    std::vector<Index> indices(part.indices.size()), place(num_vertices);
    meshopt_optimizeVertexCacheStrip(indices.data(), part.indices.data(), indices.size(),
                                     num_vertices);
    meshopt_optimizeVertexFetchRemap(place.data(), indices.data(), indices.size(), num_vertices);
    meshopt_remapIndexBuffer(part.indices.data(), indices.data(), indices.size(), place.data());
    std::vector<Index> corners(num_vertices);
    for (std::size_t v = 0; v < num_vertices; ++v) corners[place[v]] = part.corners[v];
    part.corners = std::move(corners);
}

}  // namespace pointbake
