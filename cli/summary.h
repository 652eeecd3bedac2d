// The few lines that people read: what came out, what would be done, what is in a file.
#pragma once

#include <string>
#include <vector>

#include "conversion.h"

namespace pointbake::cli {

/// What a conversion did: geometry, texture, file.
std::vector<std::string> summary_lines(const RunReport& report);

/// Each bound that was not met, with what was measured instead.
std::vector<std::string> missed_bounds(const RunReport& report);

/// What convert would do with these points, in words.
std::vector<std::string> plan_lines(const Job& job, const ConvertInput& input,
                                    const Context& context);

/// What is in a file.
std::vector<std::string> info_lines(const LoadReport& load, const CloudSummary& cloud,
                                    std::uint64_t num_faces);

}  // namespace pointbake::cli
