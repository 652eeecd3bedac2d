#include "command_setup.h"

#include <algorithm>

namespace pointbake::cli {

void add_job_options(OptionTable& table, Job& job, Stage first, Stage last) {
    const auto has = [&](Stage stage) { return first <= stage && stage <= last; };
    table.add(OptionGroup::kReading, true, job.load);
    if (has(Stage::kReconstruct)) {
        table.add(OptionGroup::kCleaning, true, job.convert.clean);
        table.add(OptionGroup::kCleaning, true, job.convert.denoise);
        table.add(OptionGroup::kGeometry, true, job.convert.reconstruct);
        table.add(OptionGroup::kGeometry, true, job.convert.attributes);
    }
    if (has(Stage::kSimplify)) table.add(OptionGroup::kGeometry, true, job.convert.simplify);
    if (has(Stage::kTexture)) {
        table.add(OptionGroup::kTexture, true, job.convert.texture);
        table.add(OptionGroup::kTexture, true, job.convert.images);
        table.add(OptionGroup::kAtlas, true, job.convert.atlas);
    }
    table.add(OptionGroup::kOutput, true, job.write);
    table.add(OptionGroup::kOutput, false, job.files);
    table.add(OptionGroup::kRunning, false, job.limits);
    table.add(OptionGroup::kRunning, false, job.run);
}

bool read_line(std::span<const std::string> words, const CommandText& text, OptionTable& table,
               ParsedLine& line) {
    // The help shows the defaults, so it is made before they are overwritten.
    const std::string help = help_text(text, table);
    line = parse_line(words, table);
    if (line.wants_help)
        print_data(help);
    else if (line.wants_version)
        print_data(fmt::format("pointbake {}{}\n", version(),
                               is_available(Method::kCocone) ? "" : ", built without CGAL"));
    else if (line.wants_dump)
        print_data(table.dump(false) + "\n");
    return !line.wants_help && !line.wants_version && !line.wants_dump;
}

void finish_job(Job& job, OptionTable& table) {
    job.all_options = table.dump(false);
    job.result_options = table.dump(true);
}

void settle_files(ParsedLine& line, std::size_t num_inputs, std::string_view what,
                  std::size_t num_at_most) {
    std::vector<std::filesystem::path> files = line.inputs;
    files.insert(files.end(), line.files.begin(), line.files.end());
    if (line.output.empty() && !line.files.empty() && files.size() > num_inputs) {
        line.output = files.back();
        files.pop_back();
    }
    if (files.size() < num_inputs) fail(ErrorCode::kInvalidOption, "missing {}; see --help", what);
    if (files.size() > std::max(num_inputs, num_at_most))
        fail(ErrorCode::kInvalidOption,
             "too many files: expected {} and an output; '{}' is one "
             "more",
             what, files.back().string());
    line.inputs = std::move(files);
}

}  // namespace pointbake::cli
