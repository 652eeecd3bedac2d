// What a model says of its place in space, beside node transforms.
#pragma once

#include <filesystem>
#include <string>

#include "write/file_set.h"

namespace pointbake {

/// "unit 0.3048 m, z up, NAD83 / UTM zone 15N, EPSG:26915", for a comment in a file; empty if the
/// frame tells nothing.
std::string frame_text(const Frame& frame);

/// The end of every writer: adds a .prj with the CRS of the report's frame beside `main`, puts all
/// files in place and names them in the report. A .prj that is there already and says something
/// else is left alone, with a warning.
void commit_with_prj(FileSet& files, const std::filesystem::path& main, WriteReport& report,
                     const Context& context);

}  // namespace pointbake
