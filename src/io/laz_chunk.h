// Chunks of a LAZ file: so many points, compressed on their own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace pointbake {

enum class LazItemKind : std::uint8_t {
    kBytes = 0,
    kPoint10 = 6,
    kGpsTime = 7,
    kRgb = 8,
    kWavePacket13 = 9,
    kPoint14 = 10,
    kRgb14 = 11,
    kRgbNir14 = 12,
    kWavePacket14 = 13,
    kBytes14 = 14
};

/// A part of each record that is compressed in a way of its own.
struct LazItem {
    LazItemKind kind = LazItemKind::kBytes;
    std::size_t num_bytes = 0;
    int version = 0;
};

/// Unpacks `records.size() / record_bytes` points, one after the other (LASzip's version 2).
/// Returns how many bytes they took; nothing if those that are there are damaged or too few.
std::optional<std::size_t> unpack_pointwise(std::span<const std::byte> bytes,
                                            std::span<const LazItem> items,
                                            std::span<std::byte> records);

/// The same for points whose parts lie in layers (versions 3 and 4).
std::optional<std::size_t> unpack_layered(std::span<const std::byte> bytes,
                                          std::span<const LazItem> items,
                                          std::span<std::byte> records);

struct LayeredSize {
    std::uint64_t num_bytes = 0;
    std::uint32_t num_points = 0;
};
/// What stands in front of a layered chunk; nothing if it does not fit into the bytes.
std::optional<LayeredSize> layered_size(std::span<const std::byte> bytes,
                                        std::span<const LazItem> items);

/// Bytes of a whole record.
std::size_t record_bytes(std::span<const LazItem> items);

}  // namespace pointbake
