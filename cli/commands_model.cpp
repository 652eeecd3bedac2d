// pointbake sample and pointbake demo: points of a mesh, and the painted model that the program
// makes itself.
#include "command_setup.h"
#include "commands.h"
#include "files.h"
#include "pointbake/model.h"
#include "pointbake/render.h"
#include "pointbake/sample.h"

namespace pointbake::cli {
namespace {

namespace fs = std::filesystem;

constexpr CommandText kSampleText = {
    "pointbake sample MESH [OUT.ply] [options]",
    "Makes points of a mesh (OBJ, GLB, glTF, PLY) and its textures; without OUT.ply:\n"
    "MESH-points.ply beside it."};
constexpr CommandText kDemoText = {
    "pointbake demo [OUT.glb] [options]",
    "Makes a painted model, writes its points as OUT-points.ply, converts that file as anybody\n"
    "would, and draws points, mesh, wires and texture: OUT-picture.png. OUT.glb is demo.glb."};

Image demo_picture(const ConvertResult& result, const Context& context) {
    const View view;
    return contact_sheet({render_points(result.cloud, view, context),
                          render_mesh(result.model.mesh, false, view, context),
                          render_mesh(result.model.mesh, true, view, context),
                          render_textured(result.model, view, context)},
                         4);
}

void make_folder_of(const fs::path& file) {
    std::error_code error;
    if (file.has_parent_path()) fs::create_directories(file.parent_path(), error);
    if (error) fail(ErrorCode::kOutput, "{}: {}", file.parent_path().string(), error.message());
}

}  // namespace

void run_sample(Words words, const std::stop_token& stop) {
    SampleOptions options;
    RunOptions run;
    OptionTable table;
    table.add(OptionGroup::kSampling, true, options);
    table.add(OptionGroup::kRunning, false, run);
    ParsedLine line;
    if (!read_line(words, kSampleText, table, line)) return;
    settle_files(line, 1, "MESH");
    const fs::path& input = line.inputs[0];
    const fs::path output =
        line.output.empty()
            ? input.parent_path() / fmt::format("{}-points.ply", input.stem().string())
            : line.output;
    constexpr std::string_view extension = ".ply";
    check_extension(output, {&extension, 1});
    check_writable(output, line.inputs);
    Console console(line.verbosity, run.progress);
    const Context context = console.context(run.threads, stop);
    const PointCloud cloud = sample(load_mesh(input, context), options, context);
    write_cloud(cloud, output, context);
    console.summary(fmt::format("wrote {}, {}", output.string(), counted(cloud.size(), "point")));
}

void run_demo(Words words, const std::stop_token& stop) {
    Job job;
    DemoOptions options;
    OptionTable table;
    table.add(OptionGroup::kSampling, true, options);
    add_job_options(table, job, Stage::kLoad, Stage::kWrite);
    ParsedLine line;
    if (!read_line(words, kDemoText, table, line)) return;
    settle_files(line, 0, "nothing");
    job.output = line.output.empty() ? "demo.glb" : line.output;
    const fs::path points = beside(job.output, "-points.ply");
    job.inputs = {points};
    const fs::path picture = beside(job.output, "-picture.png");
    finish_job(job, table);
    make_folder_of(job.output);
    check_outputs(job);
    check_writable(points, std::span(&job.output, 1));
    check_writable(picture, {});

    Console console(line.verbosity, job.run.progress);
    const Context context = console.context(job.run.threads, stop);
    write_cloud(demo_cloud(options.points, context), points, context);
    const ConvertResult result = run_job(job, console, stop);
    if (job.limits.dry_run) return;
    write_png(demo_picture(result, context), picture, context);
    console.summary(fmt::format("points {}, picture {}", points.string(), picture.string()));
}

}  // namespace pointbake::cli
