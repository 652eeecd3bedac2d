// pointbake reconstruct | simplify | texture: one stage on files. Each is a conversion that begins
// later or ends earlier.
#include "command_setup.h"
#include "commands.h"
#include "files.h"

namespace pointbake::cli {
namespace {

constexpr CommandText kReconstructText = {
    "pointbake reconstruct CLOUD [OUT.ply] [options]",
    "Makes the dense mesh over the points; without OUT.ply: CLOUD-dense.ply beside it."};
constexpr CommandText kSimplifyText = {
    "pointbake simplify MESH [OUT.ply] [options]",
    "Makes a mesh (PLY, OBJ, GLB) lighter, never farther from its points than the bound; without\n"
    "OUT.ply: MESH-light.ply beside it."};
constexpr CommandText kTextureText = {
    "pointbake texture MESH CLOUD [OUT.glb] [options]",
    "Textures a mesh (PLY, OBJ, GLB) as it is from the points of a cloud; without OUT.glb:\n"
    "MESH-textured.glb beside it."};

void run_stage(Job& job, OptionTable& table, const ParsedLine& line, std::string_view ending,
               const std::stop_token& stop) {
    job.output = line.output.empty() ? beside(line.inputs[0], ending) : line.output;
    finish_job(job, table);
    Console console(line.verbosity, job.run.progress);
    run_job(job, console, stop);
}

}  // namespace

void run_reconstruct(Words words, const std::stop_token& stop) {
    Job job;
    job.stop.stop_after = Stage::kReconstruct;
    OptionTable table;
    add_job_options(table, job, Stage::kLoad, Stage::kReconstruct);
    ParsedLine line;
    if (!read_line(words, kReconstructText, table, line)) return;
    settle_files(line, 1, "CLOUD");
    job.inputs = line.inputs;
    run_stage(job, table, line, "-dense.ply", stop);
}

void run_simplify(Words words, const std::stop_token& stop) {
    Job job;
    job.stop.stop_after = Stage::kSimplify;
    PointsOptions points;
    OptionTable table;
    table.add(OptionGroup::kGeometry, true, points);
    add_job_options(table, job, Stage::kSimplify, Stage::kSimplify);
    ParsedLine line;
    if (!read_line(words, kSimplifyText, table, line)) return;
    settle_files(line, 1, "MESH");
    job.mesh.mesh = line.inputs[0];
    job.inputs = {points.points.empty() ? line.inputs[0] : points.points};
    run_stage(job, table, line, "-light.ply", stop);
}

void run_texture(Words words, const std::stop_token& stop) {
    Job job;
    job.convert.simplify.keep_mesh = true;
    OptionTable table;
    add_job_options(table, job, Stage::kTexture, Stage::kWrite);
    ParsedLine line;
    if (!read_line(words, kTextureText, table, line)) return;
    settle_files(line, 2, "MESH and CLOUD");
    job.mesh.mesh = line.inputs[0];
    job.inputs = {line.inputs[1]};
    run_stage(job, table, line, "-textured.glb", stop);
}

}  // namespace pointbake::cli
