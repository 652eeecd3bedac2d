// What is fuzzed: each reader on its own, and what the command line is read with.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace pointbake::fuzz {

struct Target {
    std::string_view name;
    void (*run)(std::span<const std::byte> bytes);
};

/// All of them. run() returns whether the bytes were read or refused with an Error; anything else
/// is a finding.
std::span<const Target> targets();

}  // namespace pointbake::fuzz
