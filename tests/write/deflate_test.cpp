#include "write/deflate.h"

#include <gtest/gtest.h>
#include <libdeflate.h>

#include "core/hash.h"

namespace pointbake {
namespace {

std::vector<std::byte> random_bytes(std::size_t n, std::uint64_t seed, unsigned alphabet) {
    std::vector<std::byte> out(n);
    for (std::size_t i = 0; i < n; ++i) out[i] = static_cast<std::byte>(hash64(seed, i) % alphabet);
    return out;
}

/// Inputs that make stored, fixed and dynamic blocks, one and many.
std::vector<std::vector<std::byte>> samples() {
    std::vector<std::vector<std::byte>> out;
    for (const std::size_t n : {0U, 1U, 2U, 5U, 20U, 100U, 3000U, 70000U, 400000U})
        for (const unsigned alphabet : {1U, 2U, 7U, 60U, 256U})
            out.push_back(random_bytes(n, n + alphabet, alphabet));
    // Half text-like, half noise: blocks of different kinds in one stream.
    std::vector<std::byte> mixed = random_bytes(100000, 1, 5);
    const std::vector<std::byte> noise = random_bytes(100000, 2, 256);
    mixed.insert(mixed.end(), noise.begin(), noise.end());
    out.push_back(mixed);
    return out;
}

std::vector<std::byte> inflated(const std::vector<std::byte>& stream, std::size_t num_raw) {
    libdeflate_decompressor* const d = libdeflate_alloc_decompressor();
    std::vector<std::byte> out(num_raw + 1);
    std::size_t size = 0, used = 0;
    const auto result = libdeflate_deflate_decompress_ex(d, stream.data(), stream.size(),
                                                         out.data(), out.size(), &used, &size);
    libdeflate_free_decompressor(d);
    EXPECT_EQ(result, LIBDEFLATE_SUCCESS);
    EXPECT_EQ(used, stream.size());
    out.resize(size);
    return out;
}

TEST(Deflate, PiecesOfAllKindsOfBlocksMakeOneStream) {
    std::vector<std::byte> stream, raw;
    std::uint32_t adler = 1;
    const auto pieces = samples();
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const DeflatedPiece piece = deflate_piece(pieces[i], i + 1 == pieces.size());
        stream.insert(stream.end(), piece.bytes.begin(), piece.bytes.end());
        raw.insert(raw.end(), pieces[i].begin(), pieces[i].end());
        adler = adler32_combine(adler, piece.adler, piece.num_raw);
    }
    EXPECT_EQ(inflated(stream, raw.size()), raw);
    EXPECT_EQ(adler, libdeflate_adler32(1, raw.data(), raw.size()));
}

TEST(Deflate, EachPieceEndsOnAByteBorder) {
    for (const auto& sample : samples()) {
        const DeflatedPiece open = deflate_piece(sample, false);
        const DeflatedPiece last = deflate_piece({}, true);
        std::vector<std::byte> stream = open.bytes;
        stream.insert(stream.end(), last.bytes.begin(), last.bytes.end());
        EXPECT_EQ(inflated(stream, sample.size()), sample) << sample.size();
    }
}

TEST(Deflate, FindsTheFinalBlockAtEveryLevel) {
    for (const int level : {0, 1, 6, 9}) {
        libdeflate_compressor* const c = libdeflate_alloc_compressor(level);
        for (const auto& sample : samples()) {
            std::vector<std::byte> out(libdeflate_deflate_compress_bound(c, sample.size()) +
                                       kDeflateSlack);
            const std::size_t n = libdeflate_deflate_compress(c, sample.data(), sample.size(),
                                                              out.data(), out.size());
            ASSERT_GT(n, 0U);
            const FinalBlock block = find_final_block(out.data(), n);
            EXPECT_EQ((block.end_bit + 7) / 8, n);
            EXPECT_EQ(static_cast<int>(out[block.header_bit / 8]) >> (block.header_bit % 8) & 1, 1);
        }
        libdeflate_free_compressor(c);
    }
}

}  // namespace
}  // namespace pointbake
