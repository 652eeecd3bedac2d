// pointbake INPUT [OUTPUT]: the whole job.
#include <algorithm>

#include "command_setup.h"
#include "commands.h"
#include "files.h"

namespace pointbake::cli {
namespace {

constexpr CommandText kConvertText = {
    "pointbake INPUT... [OUTPUT] [options]     the whole job; without OUTPUT: INPUT.glb beside it\n"
    "pointbake info FILE                       what is in it, what a conversion would do\n"
    "pointbake reconstruct CLOUD [OUT.ply]     only the dense mesh\n"
    "pointbake simplify MESH [OUT.ply]         only a lighter mesh\n"
    "pointbake texture MESH CLOUD [OUT.glb]    only the texture, on a mesh as it is\n"
    "pointbake render FILE... [OUT.png]        a picture of clouds and models, side by side\n"
    "pointbake sample MESH [OUT.ply]           the way back: points of a mesh\n"
    "pointbake demo [OUT.glb]                  convert a painted model that the program makes",
    "Turns a point cloud into a textured mesh: GLB, glTF, OBJ, PLY, USDZ or STL (without\n"
    "texture), by the name of OUTPUT.\n"
    "Several inputs become one cloud; the last name is the output, unless -o names it.\n"
    "Each command has its own --help. Exit codes: 0 written, 1 bug, 2 usage, 3 input, 4 output,\n"
    "5 limit or bound, 6 no points left, 130 cancelled."};

constexpr std::size_t kMostInputs = 1 << 16;

/// What a run that stops before the texture is written to has no natural name beside the input.
std::filesystem::path default_output(const Job& job) {
    if (job.stop.stop_after < Stage::kTexture) return {};
    std::filesystem::path input = job.inputs[0];
    if (input == "-")
        fail(ErrorCode::kInvalidOption, "- is standard input: name the output with -o");
    if (is_packed(input)) input.replace_extension();
    return input.replace_extension(".glb");
}

/// `pointbake -q info x.ply` would otherwise be told that there is no file "info".
void check_command_first(const std::filesystem::path& input) {
    for (const Command& command : commands())
        if (input == command.name && !std::filesystem::exists(input))
            fail(ErrorCode::kInvalidOption, "the command comes first: pointbake {0} ...",
                 command.name);
    std::error_code error;
    const bool is_there = std::filesystem::exists(input, error) || error;
    if (input == "-" || input.has_extension() || input.has_parent_path() || is_there) return;
    std::vector<std::string_view> names;
    for (const Command& command : commands()) names.push_back(command.name);
    fail(ErrorCode::kInvalidOption,
         "there is neither a file nor a command '{}'; nearest command: {} (see --help)",
         input.string(), nearest_name(names, input.string()));
}

/// Two clouds in a row look like two inputs; the second must not be lost to that slip.
void check_not_points(const Job& job, bool is_named) {
    if (is_named || job.stop.stop_after <= Stage::kAttributes) return;
    std::error_code error;
    const bool is_input = std::ranges::any_of(job.inputs, [&](const auto& input) {
        return std::filesystem::equivalent(input, job.output, error);
    });
    if (is_likely_input(job.output) && !is_input)
        fail(
            ErrorCode::kInvalidOption,
            "{} exists and looks like another input: to make one cloud of all, or to overwrite it, "
            "name the output with -o",
            job.output.string());
}

/// STL holds triangles alone.
void stop_before_texture(Job& job) {
    job.stop.stop_after = std::min(job.stop.stop_after, Stage::kSimplify);
}

}  // namespace

void run_convert(Words words, const std::stop_token& stop) {
    Job job;
    OptionTable table;
    table.add(OptionGroup::kGeometry, true, job.mesh);
    add_job_options(table, job, Stage::kLoad, Stage::kWrite);
    table.add(OptionGroup::kOutput, true, job.stop);
    ParsedLine line;
    if (!read_line(words, kConvertText, table, line)) return;
    const bool is_named = !line.output.empty();
    settle_files(line, 1, "INPUT", kMostInputs);
    job.inputs = line.inputs;
    check_command_first(job.inputs[0]);
    job.output = line.output.empty() ? default_output(job) : line.output;
    check_not_points(job, is_named);
    if (lower_extension(job.output) == ".stl") stop_before_texture(job);
    finish_job(job, table);
    Console console(line.verbosity, job.run.progress);
    run_job(job, console, stop);
}

}  // namespace pointbake::cli
