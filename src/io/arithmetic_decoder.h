// Arithmetic coding with adaptive models [Said04], as LAZ files use it, and integers coded by
// their difference to a prediction [Isenburg13].
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace pointbake {

class ArithmeticDecoder;

/// How often each of n symbols was seen.
class SymbolModel {
 public:
    /// 2 to 2048 symbols.
    explicit SymbolModel(std::uint32_t num_symbols);

 private:
    friend class ArithmeticDecoder;
    void update();

    // 16 bits hold a count: 2^15 at most and what one cycle adds, 2^14 and a little. A file has
    // hundreds of models, and what is small and side by side stays in the cache.
    struct Entry {
        std::uint16_t begin = 0;  ///< of 2^15, all symbols below it
        std::uint16_t count = 1;
    };
    std::uint32_t num_symbols_;
    std::vector<Entry> entries_;        ///< per symbol, and one for their end
    std::vector<std::uint16_t> table_;  ///< by upper bits: the symbol that they begin in
    unsigned table_shift_ = 0;
    std::uint32_t total_ = 0, cycle_ = 0, until_update_ = 0;
};

/// The same for two symbols.
class BitModel {
 private:
    friend class ArithmeticDecoder;
    void update();

    std::uint32_t num_zeros_ = 1, total_ = 2;
    std::uint32_t probability_ = 1U << 12;  ///< of 0, of 2^13
    std::uint32_t cycle_ = 4, until_update_ = 4;
};

/// Models that are made when they are needed first: most contexts of a file never are.
class SymbolModels {
 public:
    SymbolModels(std::size_t num_models, std::uint32_t num_symbols)
        : models_(num_models), num_symbols_(num_symbols) {}
    SymbolModel& operator[](std::size_t i) {
        std::optional<SymbolModel>& model = models_[i];
        if (!model) model.emplace(num_symbols_);
        return *model;
    }

 private:
    std::vector<std::optional<SymbolModel>> models_;
    std::uint32_t num_symbols_;
};

/// Never reads beyond its bytes: zeros follow them, and is_overrun() tells. Whatever the bytes are,
/// symbols are in the range of their model.
class ArithmeticDecoder {
 public:
    ArithmeticDecoder() = default;  ///< of no bytes
    explicit ArithmeticDecoder(std::span<const std::byte> bytes);

    std::uint32_t symbol(SymbolModel& model);
    std::uint32_t bit(BitModel& model);
    /// `count` bits, 1 to 32, all values equally likely.
    std::uint32_t bits(unsigned count);

    /// Bytes read so far; after the last symbol, all that the encoder wrote.
    std::size_t num_read() const { return next_; }
    bool is_overrun() const { return num_missing_ > 0; }

 private:
    std::uint32_t next_byte();
    void refill();

    std::span<const std::byte> bytes_;
    std::size_t next_ = 0;
    std::size_t num_missing_ = 0;
    std::uint32_t value_ = 0, length_ = ~0U;
};

/// Integers of some bits that lie near a predicted value, modulo 2^bits.
class IntegerDecoder {
 public:
    explicit IntegerDecoder(unsigned num_bits, std::size_t num_contexts = 1);

    std::int32_t read(ArithmeticDecoder& decoder, std::int32_t predicted, std::size_t context = 0);
    /// Bits that the last difference took: what is coded next may depend on them.
    std::uint32_t num_last_bits() const { return num_last_bits_; }

 private:
    std::uint32_t read_difference(ArithmeticDecoder& decoder);
    SymbolModel& upper_bits(std::uint32_t num_bits);

    unsigned num_bits_;
    std::uint32_t num_last_bits_ = 0;
    SymbolModels sizes_;  ///< per context: how many bits the difference has
    BitModel smallest_;
    std::vector<std::optional<SymbolModel>> upper_;  ///< per number of bits
};

}  // namespace pointbake
