// What the process uses.
#pragma once

#include <cstdint>

namespace pointbake {

/// Largest resident size of the process so far.
std::uint64_t peak_memory_bytes();

}  // namespace pointbake
