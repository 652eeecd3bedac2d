// LZF, the compression inside of PCD files.
#pragma once

#include <cstddef>
#include <span>

namespace pointbake {

/// More than this many bytes cannot come from one.
inline constexpr std::size_t kMostPerLzfByte = 88;

/// Unpacks into `out`, which must be filled exactly. Returns false for damaged input; never reads
/// or writes outside of the spans.
bool unpack_lzf(std::span<const std::byte> in, std::span<std::byte> out);

}  // namespace pointbake
