// From the words of a command line to options and files, and the help. The only place that knows
// CLI11.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "option_table.h"

namespace pointbake::cli {

/// What a command is called and does, for its help.
struct CommandText {
    std::string_view usage;    ///< "pointbake info FILE"
    std::string_view summary;  ///< one or more lines
};

/// What a command line says besides the options of the table.
struct ParsedLine {
    std::vector<std::filesystem::path> files;   ///< positional, in order
    std::vector<std::filesystem::path> inputs;  ///< -i
    std::filesystem::path output;               ///< -o
    int verbosity = 0;                          ///< -1 quiet, 0, 1 (-v), 2 (-vv)
    bool wants_help = false, wants_version = false, wants_dump = false;
};

/// Reads the words after the command's name into the table; --config is read last and fills what
/// the flags leave open. Throws Error{kInvalidOption}; for an unknown option it names the nearest
/// one.
ParsedLine parse_line(std::span<const std::string> words, OptionTable& table);

/// The help of a command: usage, what it does, its options by task with their defaults.
std::string help_text(const CommandText& text, const OptionTable& table);

}  // namespace pointbake::cli
