#include "run_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>

#include "support/shapes.h"

namespace pointbake::cli {
namespace {

namespace fs = std::filesystem;

double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "pointbake-test-XXXXXX").string();
    if (!mkdtemp(name.data())) ADD_FAILURE() << "no temporary folder";
    path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code error;
    fs::permissions(path_, fs::perms::owner_all, error);
    fs::remove_all(path_, error);
}

std::vector<std::string> TemporaryFolder::files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(path_))
        names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    return names;
}

std::string TemporaryFolder::read(std::string_view name) const {
    std::ifstream file(path_ / name, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

void TemporaryFolder::write(std::string_view name, std::string_view content) const {
    std::ofstream file(path_ / name, std::ios::binary);
    file << content;
}

RunningProgram::RunningProgram(const TemporaryFolder& folder,
                               const std::vector<std::string>& arguments, int blocks)
    : start_(now()) {
    // The shell sets folder and limit, then becomes the program: signals reach it directly.
    const std::string script = fmt::format(
        "cd '{}' && [ -f stdin ] && exec <stdin; [ -f deaf ] && exec 2>/dev/full; {} exec '{}' "
        "\"$@\"",
        folder.path().string(), blocks > 0 ? fmt::format("ulimit -f {};", blocks) : "",
        POINTBAKE_PROGRAM);
    std::vector<std::string> words = {"sh", "-c", script, "pointbake"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    const std::string out = (talk_ / "out").string(), err = (talk_ / "err").string();
    constexpr int kFlags = O_WRONLY | O_CREAT | O_TRUNC;
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), kFlags, 0600);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), kFlags, 0600);
    EXPECT_EQ(posix_spawn(&process_, "/bin/sh", &actions, nullptr, argv.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
}

void RunningProgram::send(int signal) const { kill(process_, signal); }

std::string RunningProgram::err_so_far() const { return talk_.read("err"); }

ProgramRun RunningProgram::wait() {
    int status = 0;
    rusage usage{};
    EXPECT_EQ(wait4(process_, &status, 0, &usage), process_);
    ProgramRun run;
    run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    run.out = talk_.read("out");
    run.err = talk_.read("err");
    run.seconds = now() - start_;
    run.peak_kilobytes = usage.ru_maxrss;
    return run;
}

ProgramRun run_program(const TemporaryFolder& folder, const std::vector<std::string>& arguments,
                       int blocks) {
    return RunningProgram(folder, arguments, blocks).wait();
}

std::string ascii_ply(const std::vector<Vec3d>& points) {
    std::string text = fmt::format(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
        "property double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        "end_header\n",
        points.size());
    const auto shade = [](double x) {
        return static_cast<int>(std::clamp(128.0 + 100.0 * x, 0.0, 255.0));
    };
    for (const Vec3d& p : points)
        text +=
            fmt::format("{} {} {} {} {} {}\n", p.x, p.y, p.z, shade(p.x), shade(p.y), shade(p.z));
    return text;
}

std::vector<Vec3d> egg_points(std::uint64_t n) {
    std::vector<Vec3d> points;
    for (std::uint64_t i = 0; i < n; ++i) {
        const Vec3d p = shapes::fibonacci_direction(i, n);
        points.push_back({p.x, 0.8 * p.y, 0.6 * p.z});
    }
    return points;
}

}  // namespace pointbake::cli
