// What the point-wise (version 2) and the layered (version 3) compression of LASzip share.
#pragma once

#include <array>
#include <cstdint>

#include "io/arithmetic_decoder.h"

namespace pointbake {

using RawRgb = std::array<std::uint16_t, 3>;

/// Median of about the last five values.
class RunningMedian {
 public:
    std::int32_t value() const { return sorted_[2]; }
    void add(std::int32_t v);

 private:
    std::array<std::int32_t, 5> sorted_{};
    bool drops_largest_ = true;  ///< else the smallest makes room
};

/// Times as the bits of doubles, of up to four scans that take turns.
class GpsTimes {
 public:
    /// `is_always_coded`: also where the time does not change (version 2).
    GpsTimes(std::uint64_t first, bool is_always_coded);

    std::uint64_t value() const { return times_[last_]; }
    /// Returns false for damaged bytes.
    bool read(ArithmeticDecoder& decoder);

 private:
    enum class Step { kDone, kSwitched };
    Step read_first(ArithmeticDecoder& decoder);
    Step read_next(ArithmeticDecoder& decoder);
    void start_scan(ArithmeticDecoder& decoder);
    void switch_scan(std::uint32_t by) { last_ = (last_ + by) & 3U; }
    void advance(std::int32_t difference);
    void count_extreme(std::int32_t difference);

    bool is_always_coded_;
    std::uint32_t last_ = 0, newest_ = 0;
    std::array<std::uint64_t, 4> times_{};
    std::array<std::int32_t, 4> differences_{};
    std::array<int, 4> num_extreme_{};  ///< in a row, whose step is far from the usual one
    SymbolModel first_codes_, next_codes_;
    IntegerDecoder steps_{32, 9};
};

/// Colours, byte by byte.
class RgbDecoder {
 public:
    RawRgb read(ArithmeticDecoder& decoder, const RawRgb& last);

 private:
    std::uint32_t read_byte(ArithmeticDecoder& decoder, std::uint32_t changes, std::size_t which,
                            std::uint32_t last, int difference);

    SymbolModel changes_{128};
    SymbolModels bytes_{6, 256};
};

/// |n - r|, at most 7, for return r of n.
std::size_t return_level(std::uint32_t n, std::uint32_t r);

/// Which of two contexts of a pair, and the rest of it even: LASzip's for y and z.
std::size_t size_context(bool is_single, std::uint32_t num_bits, std::uint32_t most);

}  // namespace pointbake
