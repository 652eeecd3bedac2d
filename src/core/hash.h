// Random numbers without state: a hash of (seed, index) or of a place.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "pointbake/vec.h"

namespace pointbake {

/// SplitMix64's finaliser [Steele14]: every input bit reaches every output bit.
constexpr std::uint64_t hash64(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
}
constexpr std::uint64_t hash64(std::uint64_t seed, std::uint64_t index) {
    return hash64(hash64(seed) ^ index);
}

/// Of a place, by the bits of its coordinates; -0 counts as 0.
constexpr std::uint64_t hash_of(Vec3d v) {
    std::uint64_t hash = 0;
    for (std::size_t k = 0; k < 3; ++k)
        hash = hash64(hash, std::bit_cast<std::uint64_t>(v[k] + 0.0));
    return hash;
}

/// Uniform in [0, 1).
constexpr double random_unit(std::uint64_t seed, std::uint64_t index) {
    return static_cast<double>(hash64(seed, index) >> 11) * 0x1.0p-53;
}

}  // namespace pointbake
