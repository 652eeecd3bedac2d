// Wavefront OBJ with MTL.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Whether the text looks like OBJ: its first statement is one of OBJ's.
bool is_obj(std::span<const std::byte> bytes);

/// `path` is for messages, and tells where material libraries and textures lie. Throws
/// Error{kInvalidInput} with the line.
TexturedMesh read_obj(std::span<const std::byte> bytes, const std::filesystem::path& path,
                      const Context& context);

}  // namespace pointbake
