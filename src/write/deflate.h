// One zlib stream out of pieces that are compressed independently, on several threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace pointbake {

/// The compressed bytes of one piece, ending on a byte border. Pieces' bytes concatenated are one
/// deflate stream if the last one, and only it, was compressed with is_last.
struct DeflatedPiece {
    std::vector<std::byte> bytes;
    std::uint32_t adler = 1;  ///< Adler-32 of the raw bytes
    std::size_t num_raw = 0;
};
DeflatedPiece deflate_piece(std::span<const std::byte> raw, bool is_last);

/// The Adler-32 of two byte strings one after the other, from those of each.
std::uint32_t adler32_combine(std::uint32_t first, std::uint32_t second, std::size_t num_second);

/// Where a deflate stream's final block begins and ends, in bits.
struct FinalBlock {
    std::size_t header_bit = 0, end_bit = 0;
};
/// `stream` must be well-formed and be followed by kDeflateSlack readable bytes.
inline constexpr std::size_t kDeflateSlack = 8;
FinalBlock find_final_block(const std::byte* stream, std::size_t num_bytes);

}  // namespace pointbake
