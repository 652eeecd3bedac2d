// What a model says of its place in space, beside node transforms.
#pragma once

#include <filesystem>
#include <string>

#include "write/file_set.h"

namespace pointbake {

/// "unit 0.3048 m, z up, NAD83 / UTM zone 15N, EPSG:26915", for a comment in a file; empty if the
/// frame tells nothing.
std::string frame_text(const Frame& frame);

/// Adds a .prj with the CRS beside `main` and names it in the report; one that is there already and
/// says something else is left alone, with a warning.
void add_prj(FileSet& files, const std::filesystem::path& main, const Frame& frame,
             WriteReport& report, const Context& context);

}  // namespace pointbake
