// What people read about axes, units, and the place of a model in the world.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "pointbake/report.h"

namespace pointbake::cli {

/// One line for each thing that was decided: axes, units, global shift, CRS.
std::vector<std::string> frame_lines(const RunReport& report);

/// (label, text) for what is known of a file: axes, unit, CRS, scanners.
std::vector<std::pair<std::string, std::string>> frame_facts(const Frame& frame,
                                                             const LoadReport& load);

}  // namespace pointbake::cli
