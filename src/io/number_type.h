// The number types of binary files, and values of them in any byte order.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace pointbake {

enum class NumberType : std::uint8_t {
    kInt8,
    kUint8,
    kInt16,
    kUint16,
    kInt32,
    kUint32,
    kInt64,
    kUint64,
    kFloat32,
    kFloat64
};
std::size_t size_of(NumberType type);
constexpr bool is_float(NumberType type) {
    return type == NumberType::kFloat32 || type == NumberType::kFloat64;
}
constexpr bool is_8bit(NumberType type) {
    return type == NumberType::kInt8 || type == NumberType::kUint8;
}

/// A value of type T wherever it lies; `swap`: its bytes are in the other order than this
/// machine's.
template <class T>
T load_value(const std::byte* from, bool swap = false) {
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), from, sizeof(T));
    if (swap) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
}

double load_as_double(NumberType type, const std::byte* from, bool swap = false);

/// Values that stand `stride` bytes apart, the first at `from`, as doubles: `to.size()` of them.
void load_column(NumberType type, const std::byte* from, std::size_t stride, bool swap,
                 std::span<double> to);

}  // namespace pointbake
