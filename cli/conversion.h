// One conversion from files to files: check, load, convert, write, tell. All commands that make a
// mesh are one of these with other options.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "console.h"
#include "pointbake/report.h"
#include "run_options.h"

namespace pointbake::cli {

struct Job {
    std::vector<std::filesystem::path> inputs;  ///< points
    std::filesystem::path output;               ///< empty: only the work directory
    LoadOptions load;
    ConvertOptions convert;
    WriteOptions write;
    MeshOptions mesh;
    StopOptions stop;
    FileOptions files;
    LimitOptions limits;
    RunOptions run;
    std::string all_options = "{}";     ///< JSON, for the work directory
    std::string result_options = "{}";  ///< JSON, for the report
};

/// Before the long work: can everything be written where it shall go? Throws Error{kOutput}, or
/// Error{kInvalidOption} for names that do not do.
void check_outputs(const Job& job);

/// Runs it and returns every stage's value (empty after --dry-run). Throws Error; Error{kLimit}
/// when a bound is missed under --strict.
ConvertResult run_job(const Job& job, Console& console, const std::stop_token& stop);

}  // namespace pointbake::cli
