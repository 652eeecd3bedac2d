// Meshes of KHR_draco_mesh_compression.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pointbake/types.h"

namespace pointbake {

/// One attribute of all vertices.
struct DracoAttribute {
    enum class Kind { kGrid, kUnit, kExact16 };  ///< floats, unit vectors, 16-bit integers
    std::string name;                            ///< as glTF has it
    Kind kind = Kind::kGrid;
    std::size_t num_components = 0;
    std::vector<std::byte> elements;
    int exponent = 0;  ///< of kGrid: rounded to multiples of 2^exponent
};

/// Counts are those that a decoder finds: vertices may be merged or split, and change their order.
struct DracoMesh {
    std::vector<std::byte> bytes;
    std::size_t num_vertices = 0, num_triangles = 0;
    std::vector<int> ids;  ///< per attribute
};

/// The same bytes for the same input. Throws Error{kLimit} where a grid has more than 2^30 steps.
DracoMesh draco_mesh(std::span<const Index> indices, std::span<const DracoAttribute> attributes,
                     std::size_t num_vertices);

}  // namespace pointbake
