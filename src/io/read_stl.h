// STL, text and binary: triangles without shared vertices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Binary: the count of triangles fits the number of bytes. Text: "solid", then "facet".
bool is_stl(std::span<const std::byte> bytes);

struct StlFile {
    TexturedMesh mesh;
    std::uint64_t num_bad_facets = 0;  ///< left out: fewer than three corners, or not finite
    std::vector<std::string> notes;    ///< about these, and whether the end is there
};

/// `path` is for messages. Equal corners become one vertex; normals and colours are left out.
/// Throws Error{kInvalidInput, kLimit, kEmpty}.
StlFile read_stl(std::span<const std::byte> bytes, const std::filesystem::path& path,
                 const Context& context);

}  // namespace pointbake
