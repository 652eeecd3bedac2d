// What the commands have in common: reading their words, answering --help and its like.
#pragma once

#include "command_line.h"
#include "conversion.h"

namespace pointbake::cli {

/// The options of all stages from `first` to `last`, and of the run.
void add_job_options(OptionTable& table, Job& job, Stage first, Stage last);

/// Reads the words. False if the line only asked for help, version or options, which it then got.
bool read_line(std::span<const std::string> words, const CommandText& text, OptionTable& table,
               ParsedLine& line);

/// What every command that converts does once its words are read: units, options for the record.
void finish_job(Job& job, OptionTable& table);

/// Moves the last positional file to `output` unless -o named one and if there are more than
/// `num_inputs`; then checks that so many inputs are left, or up to `num_at_most`. `what` names
/// them in messages.
void settle_files(ParsedLine& line, std::size_t num_inputs, std::string_view what,
                  std::size_t num_at_most = 0);

}  // namespace pointbake::cli
