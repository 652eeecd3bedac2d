// Based on [Said04]: intervals of 32 bits, probabilities of 15 bits (13 for bits) that are brought
// up to date at intervals that grow. All constants are LASzip's, since both sides must agree.
#include "io/arithmetic_decoder.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

namespace pointbake {
namespace {

constexpr unsigned kSymbolShift = 15, kBitShift = 13;
constexpr std::uint32_t kMaxCount = 1U << kSymbolShift;
constexpr std::uint32_t kMaxBitCount = 1U << kBitShift;
constexpr unsigned kMostDirectBits = 19;  // in one division
constexpr unsigned kUpperBits = 8;        // of a difference, coded by a model

}  // namespace

SymbolModel::SymbolModel(std::uint32_t num_symbols)
    : num_symbols_(num_symbols), entries_(num_symbols + 1) {
    entries_.back().begin = std::numeric_limits<std::uint16_t>::max();
    const auto table_bits = static_cast<unsigned>(std::bit_width(num_symbols));
    table_.resize(std::size_t{1} << table_bits);
    table_shift_ = kSymbolShift - table_bits;
    cycle_ = num_symbols;
    update();
    cycle_ = until_update_ = (num_symbols + 6) / 2;
}

void SymbolModel::update() {
    total_ += cycle_;
    if (total_ > kMaxCount) {
        total_ = 0;
        for (std::uint32_t k = 0; k < num_symbols_; ++k) {
            std::uint16_t& count = entries_[k].count;
            count = static_cast<std::uint16_t>((count + 1) / 2);
            total_ += count;
        }
    }
    const std::uint32_t scale = 0x80000000U / total_;
    std::uint32_t sum = 0;
    std::size_t slot = 0;
    for (std::uint32_t k = 0; k < num_symbols_; ++k) {
        const std::uint32_t begin = (scale * sum) >> (31 - kSymbolShift);
        entries_[k].begin = static_cast<std::uint16_t>(begin);
        sum += entries_[k].count;
        for (; slot << table_shift_ < begin; ++slot)
            table_[slot] = static_cast<std::uint16_t>(k - 1);
    }
    for (; slot < table_.size(); ++slot)
        table_[slot] = static_cast<std::uint16_t>(num_symbols_ - 1);
    cycle_ = std::min(cycle_ * 5 / 4, (num_symbols_ + 6) * 8);
    until_update_ = cycle_;
}

void BitModel::update() {
    constexpr std::uint32_t kLongestCycle = 64;
    total_ += cycle_;
    if (total_ > kMaxBitCount) {
        total_ = (total_ + 1) / 2;
        num_zeros_ = (num_zeros_ + 1) / 2;
        if (num_zeros_ == total_) ++total_;
    }
    const std::uint32_t scale = 0x80000000U / total_;
    probability_ = (num_zeros_ * scale) >> (31 - kBitShift);
    cycle_ = std::min(cycle_ * 5 / 4, kLongestCycle);
    until_update_ = cycle_;
}

ArithmeticDecoder::ArithmeticDecoder(std::span<const std::byte> bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) value_ = value_ << 8 | next_byte();
}

std::uint32_t ArithmeticDecoder::next_byte() {
    if (next_ < bytes_.size()) return std::to_integer<std::uint32_t>(bytes_[next_++]);
    ++num_missing_;
    return 0;
}

/// Brings the length of the interval back to at least 2^24.
inline void ArithmeticDecoder::refill() {
    // Without a branch, as nobody could guess which symbols take a byte.
    const auto num_bits = static_cast<unsigned>(std::countl_zero(length_)) & ~7U;
    length_ <<= num_bits;
    if (next_ + sizeof(std::uint32_t) <= bytes_.size()) {
        static_assert(std::endian::native == std::endian::little);
        std::uint32_t next = 0;
        std::memcpy(&next, &bytes_[next_], sizeof next);
        const std::uint64_t both = std::uint64_t{value_} << 32 | __builtin_bswap32(next);
        value_ = static_cast<std::uint32_t>(both >> (32 - num_bits));
        next_ += num_bits / 8;
        return;
    }
    for (unsigned n = 0; n < num_bits; n += 8) value_ = value_ << 8 | next_byte();
}

std::uint32_t ArithmeticDecoder::symbol(SymbolModel& model) {
    SymbolModel::Entry* const entries = model.entries_.data();
    const std::uint32_t part = length_ >> kSymbolShift;
    // Of damaged bytes the value may lie outside of the interval.
    const std::uint32_t place = std::min(value_ / part, kMaxCount - 1);
    std::uint32_t found = model.table_[place >> model.table_shift_];
    while (entries[found + 1].begin <= place) ++found;
    const std::uint32_t low = entries[found].begin * part;
    const std::uint32_t high =
        found + 1 == model.num_symbols_ ? length_ : entries[found + 1].begin * part;
    value_ -= low;
    length_ = high - low;
    refill();
    ++entries[found].count;
    if (--model.until_update_ == 0) model.update();
    return found;
}

std::uint32_t ArithmeticDecoder::bit(BitModel& model) {
    const std::uint32_t zeros = model.probability_ * (length_ >> kBitShift);
    const bool is_one = value_ >= zeros;
    if (is_one) {
        value_ -= zeros;
        length_ -= zeros;
    } else {
        length_ = zeros;
        ++model.num_zeros_;
    }
    refill();
    if (--model.until_update_ == 0) model.update();
    return is_one ? 1 : 0;
}

std::uint32_t ArithmeticDecoder::bits(unsigned count) {
    if (count > kMostDirectBits) {
        const std::uint32_t lower = bits(16);
        return bits(count - 16) << 16 | lower;
    }
    length_ >>= count;
    const std::uint32_t found = std::min(value_ / length_, (1U << count) - 1);
    value_ -= length_ * found;
    refill();
    return found;
}

IntegerDecoder::IntegerDecoder(unsigned num_bits, std::size_t num_contexts)
    : num_bits_(num_bits), sizes_(num_contexts, num_bits + 1), upper_(num_bits + 1) {}

SymbolModel& IntegerDecoder::upper_bits(std::uint32_t num_bits) {
    std::optional<SymbolModel>& model = upper_[num_bits];
    if (!model) model.emplace(1U << std::min(num_bits, kUpperBits));
    return *model;
}

/// Differences of k bits are those from -(2^k - 1) to -2^(k-1) and from 2^(k-1) + 1 to 2^k.
std::uint32_t IntegerDecoder::read_difference(ArithmeticDecoder& decoder) {
    const std::uint32_t k = num_last_bits_;
    if (k == 0) return decoder.bit(smallest_);
    if (k >= 32) return 0x80000000U;
    std::uint32_t c = decoder.symbol(upper_bits(k));
    if (k > kUpperBits) {
        const unsigned num_lower = k - kUpperBits;
        c = c << num_lower | decoder.bits(num_lower);
    }
    return c >= 1U << (k - 1) ? c + 1 : c - ((1U << k) - 1);
}

std::int32_t IntegerDecoder::read(ArithmeticDecoder& decoder, std::int32_t predicted,
                                  std::size_t context) {
    num_last_bits_ = decoder.symbol(sizes_[context]);
    const std::uint32_t sum = static_cast<std::uint32_t>(predicted) + read_difference(decoder);
    const std::uint32_t kept = num_bits_ < 32 ? sum & ((1U << num_bits_) - 1) : sum;
    return static_cast<std::int32_t>(kept);
}

}  // namespace pointbake
