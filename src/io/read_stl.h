// STL, text and binary: triangles without shared vertices.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Binary: the count of triangles fits the number of bytes. Text: "solid", then "facet".
bool is_stl(std::span<const std::byte> bytes);

/// `path` is for messages. Equal corners become one vertex; normals and colours are left out.
/// Throws Error{kInvalidInput, kLimit, kEmpty}.
TexturedMesh read_stl(std::span<const std::byte> bytes, const std::filesystem::path& path,
                      const Context& context);

}  // namespace pointbake
