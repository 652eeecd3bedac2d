// What the process uses.
#pragma once

#include <cstdint>

namespace pointbake {

/// Largest resident size of the process so far.
std::uint64_t peak_memory_bytes();

/// Resident size now, without the pages of files; 0 where the system does not tell.
std::uint64_t memory_bytes();

}  // namespace pointbake
