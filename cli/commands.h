// The commands of the program. Each takes the words after its name and throws Error.
#pragma once

#include <span>
#include <stop_token>
#include <string>
#include <string_view>

namespace pointbake::cli {

using Words = std::span<const std::string>;

void run_convert(Words words, const std::stop_token& stop);
void run_reconstruct(Words words, const std::stop_token& stop);
void run_simplify(Words words, const std::stop_token& stop);
void run_texture(Words words, const std::stop_token& stop);
void run_info(Words words, const std::stop_token& stop);
void run_render(Words words, const std::stop_token& stop);
void run_sample(Words words, const std::stop_token& stop);
void run_demo(Words words, const std::stop_token& stop);

struct Command {
    std::string_view name;
    void (*run)(Words, const std::stop_token&);
};
std::span<const Command> commands();

}  // namespace pointbake::cli
