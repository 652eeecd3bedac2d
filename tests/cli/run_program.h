// Runs the program as a user does, in a folder of its own, and tells what came of it.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pointbake/types.h"

namespace pointbake::cli {

/// A new folder that is removed at the end.
class TemporaryFolder {
 public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path operator/(std::string_view name) const { return path_ / name; }
    /// Names of everything in it, sorted.
    std::vector<std::string> files() const;
    std::string read(std::string_view name) const;
    void write(std::string_view name, std::string_view content) const;

 private:
    std::filesystem::path path_;
};

struct ProgramRun {
    int exit_code = -1;  ///< 128 + signal if one killed it
    std::string out, err;
    double seconds = 0.0;
    long peak_kilobytes = 0;
};

/// A program that is running; its folder is `folder`. A file `stdin` there is its standard input;
/// with a file `deaf` nothing can be written to stderr.
class RunningProgram {
 public:
    /// blocks: largest file it may write, in units of 512 bytes; 0 = no limit.
    RunningProgram(const TemporaryFolder& folder, const std::vector<std::string>& arguments,
                   int blocks = 0);
    void send(int signal) const;
    /// What it has written to stderr so far.
    std::string err_so_far() const;
    ProgramRun wait();

 private:
    TemporaryFolder talk_;  // its stdout and stderr, apart from its files
    pid_t process_ = -1;
    double start_ = 0.0;
};

ProgramRun run_program(const TemporaryFolder& folder, const std::vector<std::string>& arguments,
                       int blocks = 0);

/// An ASCII PLY of points, coloured by their place.
std::string ascii_ply(const std::vector<Vec3d>& points);
/// n points on an ellipsoid with the half-axes 1, 0.8, 0.6: closed, and no four of them on a sphere
/// but by chance, which would make exact arithmetic slow.
std::vector<Vec3d> egg_points(std::uint64_t n);

}  // namespace pointbake::cli
