#include "command_line.h"

#include <CLI/CLI.hpp>
#include <array>
#include <fstream>
#include <sstream>

namespace pointbake::cli {
namespace {

/// Options that every command has, beside the table's.
struct CommonOption {
    std::string_view flags;  ///< as CLI11 takes them
    std::string_view shown;
    std::string_view help;
};
constexpr std::array<CommonOption, 8> kCommonOptions = {{
    {"-i,--input", "-i, --input FILE", "input, also without -i"},
    {"-o,--output", "-o, --output FILE", "output, also as the last word"},
    {"--config", "--config FILE", "read options from a JSON file; flags win"},
    {"--dump-options", "--dump-options", "print all options as JSON and stop"},
    {"-q,--quiet", "-q, --quiet", "only warnings and errors"},
    {"-v,--verbose", "-v, --verbose", "more talk; twice for still more"},
    {"--version", "--version", "print the version and stop"},
    {"-h,--help", "-h, --help", "print this and stop"},
}};

constexpr std::array<std::string_view, 8> kGroupTitles = {
    "Reading", "Cleaning", "Geometry", "Texture", "Atlas", "Sampling", "Output", "Running"};

constexpr std::size_t kHelpWidth = 96;   // columns of a line of help
constexpr std::size_t kHelpIndent = 34;  // column at which the explanations begin

std::string_view long_name(std::string_view flags) { return flags.substr(flags.find("--") + 2); }

[[noreturn]] void fail_unknown(std::string_view word, const OptionTable& table) {
    if (!word.starts_with("--"))
        fail(ErrorCode::kInvalidOption, "unknown option {}; see --help", word);
    std::vector<std::string_view> known = table.names();
    for (const CommonOption& option : kCommonOptions) known.push_back(long_name(option.flags));
    const std::string_view name = word.substr(2);
    fail(ErrorCode::kInvalidOption, "unknown option {}; nearest: --{}", word,
         nearest_name(known, name.substr(0, name.find('='))));
}

/// Appends "head   explanation", the explanation wrapped.
void append_entry(std::string& text, std::string_view head, std::string_view explanation) {
    std::string line = fmt::format("  {}", head);
    if (line.size() + 2 > kHelpIndent) {
        text += line + "\n";
        line.clear();
    }
    line.resize(kHelpIndent, ' ');
    std::istringstream words{std::string(explanation)};
    for (std::string word; words >> word;) {
        if (line.size() + 1 + word.size() > kHelpWidth) {
            text += line + "\n";
            line.assign(kHelpIndent, ' ');
        }
        if (line.size() > kHelpIndent) line += ' ';
        line += word;
    }
    text += line + "\n";
}

/// The default as it would be typed; empty where there is none to tell.
std::string default_text(const OptionEntry& entry) {
    std::string text = entry.default_json;
    if (entry.placeholder.empty() || text == "null" || text == "\"\"") return {};
    if (text.starts_with('"')) text = text.substr(1, text.size() - 2);
    return fmt::format(" [{}]", text);
}

std::string read_config(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    if (!std::filesystem::is_regular_file(path) || !(text << file.rdbuf()))
        fail(ErrorCode::kIo, "--config {}: cannot be read as a file", path.string());
    return text.str();
}

}  // namespace

ParsedLine parse_line(std::span<const std::string> words, OptionTable& table) {
    CLI::App app;
    app.set_help_flag();
    app.allow_extras();
    std::vector<CLI::Option*> options;
    for (const OptionEntry& entry : table.entries()) {
        CLI::Option* const option = entry.placeholder.empty()
                                        ? app.add_flag("--" + entry.name)
                                        : app.add_option("--" + entry.name)->expected(1);
        options.push_back(option->take_last());
    }
    ParsedLine line;
    std::string output, config;
    std::vector<std::string> inputs, files;
    app.add_option("-i,--input", inputs)->allow_extra_args(false);
    app.add_option("-o,--output", output)->take_last();
    app.add_option("--config", config)->take_last();
    app.add_flag("--dump-options", line.wants_dump);
    app.add_flag("--version", line.wants_version);
    app.add_flag("-h,--help", line.wants_help);
    const CLI::Option* const quiet = app.add_flag("-q,--quiet");
    const CLI::Option* const verbose = app.add_flag("-v,--verbose");
    app.add_option("files", files);

    try {
        app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
    } catch (const CLI::ArgumentMismatch& error) {
        const std::string text = error.what();
        fail(ErrorCode::kInvalidOption, "{} needs a value; see --help",
             text.substr(0, text.find(':')));
    } catch (const CLI::ParseError& error) {
        fail(ErrorCode::kInvalidOption, "{}", error.what());
    }
    for (const std::string& word : app.remaining()) fail_unknown(word, table);
    for (std::size_t i = 0; i < options.size(); ++i) {
        if (options[i]->count() == 0) continue;
        table.set(table.entries()[i].name, options[i]->results().back());
    }
    if (!config.empty()) table.set_from_json(read_config(config), config);

    line.files.assign(files.begin(), files.end());
    line.inputs.assign(inputs.begin(), inputs.end());
    line.output = output;
    line.verbosity = quiet->count() > 0 ? -1 : static_cast<int>(verbose->count());
    return line;
}

std::string help_text(const CommandText& text, const OptionTable& table) {
    std::string help = fmt::format("{}\n\n{}\n", text.usage, text.summary);
    for (std::size_t group = 0; group < kGroupTitles.size(); ++group) {
        std::string section;
        for (const OptionEntry& entry : table.entries()) {
            if (static_cast<std::size_t>(entry.group) != group) continue;
            append_entry(section, fmt::format("--{} {}", entry.name, entry.placeholder),
                         entry.help + default_text(entry));
        }
        if (!section.empty()) help += fmt::format("\n{}\n{}", kGroupTitles[group], section);
    }
    help += "\nCommon\n";
    for (const CommonOption& option : kCommonOptions) append_entry(help, option.shown, option.help);
    return help;
}

}  // namespace pointbake::cli
