// glTF 2.0 meshes, as GLB or as JSON with its buffers.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Reads the triangles of the default scene with their node transforms, base colours and their
/// textures, and vertex colours. Points, lines, skins and morph targets are left out. Throws
/// Error{kInvalidInput, kUnsupported, kIo, kEmpty}.
TexturedMesh read_gltf(std::span<const std::byte> bytes, const std::filesystem::path& path,
                       const Context& context);

}  // namespace pointbake
