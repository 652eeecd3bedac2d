// The files of a conversion, read.
#pragma once

#include <filesystem>

#include "pointbake/context.h"
#include "pointbake/load.h"

namespace pointbake::cli {

/// The points of a file. Where it is an OBJ or a glTF they are the vertices of its mesh.
LoadResult load_points(const std::filesystem::path& path, const Context& context);

}  // namespace pointbake::cli
