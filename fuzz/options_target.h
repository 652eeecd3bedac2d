// The options of a conversion, from words and from JSON.
#pragma once

#include <cstddef>
#include <span>

namespace pointbake::fuzz {

/// Text that begins with '{' is what --config reads; anything else are the words of a command
/// line, one per line.
void run_options(std::span<const std::byte> bytes);

}  // namespace pointbake::fuzz
