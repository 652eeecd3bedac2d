// Buffer views of EXT_meshopt_compression.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "write/split.h"

namespace pointbake {

/// A compressed view and how it is to be read.
struct MeshoptView {
    std::vector<std::byte> bytes;
    std::string_view mode, filter;
};

/// Indices of triangles; a decoder may turn each triangle's corners.
MeshoptView meshopt_indices(std::span<const Index> indices);
/// `count` elements of `stride` bytes, a multiple of 4. With an exponent they are floats, written
/// as multiples of 2^exponent, up to 2^23 of them.
MeshoptView meshopt_attribute(std::span<const std::byte> elements, std::size_t stride,
                              std::optional<int> exponent);

/// Triangles and vertices in an order that compresses well.
void reorder_in_place(MeshPart& part);

}  // namespace pointbake
