// --work-dir: what each stage hands on, as files that other programs open.
#pragma once

#include <filesystem>

#include "pointbake/convert.h"
#include "pointbake/write.h"

namespace pointbake::cli {

/// The points in their present state, the dense mesh, the light one or the textured one, as a file.
/// Points are written as PLY, meshes by extension. Returns what was written.
WriteReport write_stage(Stage stage, const ConvertResult& result, const std::filesystem::path& path,
                        const WriteOptions& options, const Context& context);

/// Writes 1-attributes.ply, 2-reconstruct.ply, 3-simplify.ply, 4-texture.glb and its pages as
/// 4-texture-0.png, ... into the folder, each after its stage.
StageObserver work_dir_observer(const std::filesystem::path& folder, const WriteOptions& options,
                                const Context& context);

}  // namespace pointbake::cli
