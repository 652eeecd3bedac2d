#include "options_target.h"

#include <string>
#include <vector>

#include "command_line.h"
#include "io/text_layout.h"
#include "option_table.h"
#include "pointbake/write.h"
#include "run_options.h"

namespace pointbake::fuzz {
namespace {

using cli::OptionGroup;

/// Every options struct that a conversion has.
struct Options {
    LoadOptions load;
    ConvertOptions convert;
    WriteOptions write;
    cli::MeshOptions mesh;
    cli::StopOptions stop;
    cli::FileOptions files;
    cli::LimitOptions limits;
    cli::RunOptions run;
    cli::OptionTable table;

    Options() {
        const auto add = [&](auto& options) { table.add(OptionGroup::kRunning, true, options); };
        add(load);
        add(convert.clean);
        add(convert.denoise);
        add(convert.attributes);
        add(convert.reconstruct);
        add(convert.simplify);
        add(convert.texture);
        add(convert.atlas);
        add(write);
        add(mesh);
        add(stop);
        add(files);
        add(limits);
        add(run);
    }
};

std::vector<std::string> lines(std::string_view text) {
    std::vector<std::string> words;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        words.emplace_back(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return words;
}

/// A file that is named may be any file of the machine: that is not fuzzing.
bool names_config(const std::vector<std::string>& words) {
    for (const std::string& word : words)
        if (word.starts_with("--c")) return true;
    return false;
}

}  // namespace

void run_options(std::span<const std::byte> bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    Options options;
    if (text.starts_with('{')) {
        options.table.set_from_json(text, "fuzz.json");
    } else {
        const std::vector<std::string> words = lines(text);
        if (names_config(words)) return;
        cli::parse_line(words, options.table);
    }
    if (!options.load.columns.empty()) parse_columns(options.load.columns);
    options.table.dump(false);
}

}  // namespace pointbake::fuzz
