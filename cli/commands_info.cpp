// pointbake info FILE: what is in a file, and what a conversion would do with it.
#include "command_setup.h"
#include "commands.h"
#include "files.h"
#include "summary.h"

namespace pointbake::cli {
namespace {

constexpr CommandText kInfoText = {
    "pointbake info FILE [options]",
    "Tells what is in a file: points, attributes with their ranges, extent, spacing, defects, and\n"
    "what a conversion without options would do."};

}  // namespace

void run_info(Words words, const std::stop_token& stop) {
    InfoOptions info;
    Job job;
    OptionTable table;
    table.add(OptionGroup::kReading, false, job.load);
    table.add(OptionGroup::kOutput, false, info);
    table.add(OptionGroup::kRunning, false, job.run);
    ParsedLine line;
    if (!read_line(words, kInfoText, table, line)) return;
    settle_files(line, 1, "FILE");
    if (!line.output.empty())
        fail(ErrorCode::kInvalidOption, "info writes to stdout: '{}' is one file too many",
             line.output.string());
    Console console(line.verbosity, job.run.progress);
    const Context context = console.context(job.run.threads, stop);
    LoadResult loaded = load_cloud(line.inputs[0], job.load, context);
    const CloudSummary cloud = summarize(loaded.cloud, context);
    const std::uint64_t num_faces = loaded.mesh ? loaded.mesh->triangles.size() : 0;
    console.clear();
    if (info.json)
        return print_data(info_json(line.inputs[0].string(), loaded.report, cloud, num_faces));
    std::string text;
    for (const std::string& entry : info_lines(loaded.report, cloud, num_faces))
        text += entry + "\n";
    text += "\npointbake would\n";
    job.inputs = line.inputs;
    job.output = std::filesystem::path(line.inputs[0]).replace_extension(".glb");
    const ConvertInput input{
        .cloud = std::move(loaded.cloud), .file_mesh = std::move(loaded.mesh), .mesh = {}};
    const std::vector<std::string> plan =
        naming(line.inputs[0].string(), [&] { return plan_lines(job, input, context); });
    for (const std::string& entry : plan) text += entry + "\n";
    print_data(text);
}

}  // namespace pointbake::cli
