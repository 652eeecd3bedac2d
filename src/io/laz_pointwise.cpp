// The compression of point formats 0 to 5: all parts of a point, then the next point, in one
// stream. The first point of a chunk is not compressed.
#include <array>
#include <cstring>
#include <memory>

#include "io/laz_chunk.h"
#include "io/laz_models.h"
#include "io/number_type.h"

namespace pointbake {
namespace {

template <class T>
void store_value(std::byte* to, T value) {
    std::memcpy(to, &value, sizeof(T));
}

/// A part of the records. Buffers hold as many bytes as the part has.
class Item {
 public:
    virtual ~Item() = default;
    virtual void begin(const std::byte* first) = 0;
    /// Returns false for damaged bytes.
    virtual bool read(ArithmeticDecoder& decoder, std::byte* to) = 0;
};

// LASzip's contexts for return r of n, in hexadecimal; those that cannot be have one, too.
constexpr std::array<const char*, 8> kReturnContexts{
    "fedcba98", "e0136aa9", "d1247bba", "c3458ccb", "b6789ddc", "aabcdeed", "9abcdefe", "89abcdef"};

std::size_t return_context(std::uint32_t n, std::uint32_t r) {
    const char digit = kReturnContexts[n][r];
    return static_cast<std::size_t>(digit <= '9' ? digit - '0' : digit - 'a' + 10);
}

class Point10Item : public Item {
 public:
    static constexpr std::size_t kBytes = 20;

    void begin(const std::byte* first) override {
        for (std::size_t k = 0; k < 3; ++k) position_[k] = load_value<std::int32_t>(first + 4 * k);
        for (std::size_t k = 0; k < 4; ++k) bytes_[k] = load_value<std::uint8_t>(first + 14 + k);
        source_id_ = load_value<std::uint16_t>(first + 18);
    }

    bool read(ArithmeticDecoder& decoder, std::byte* to) override {
        const std::uint32_t changes = decoder.symbol(changes_);
        if ((changes & kFlagsChange) != 0) read_byte(decoder, flag_models_, bytes_[kFlags]);
        const std::uint32_t r = bytes_[kFlags] & 7U, n = bytes_[kFlags] >> 3 & 7U;
        const std::size_t context = return_context(n, r);
        if (changes != 0) read_changes(decoder, changes, context);
        read_position(decoder, context, n == 1, return_level(n, r));
        store(to);
        return true;
    }

 private:
    enum Byte : std::size_t { kFlags, kClass, kAngle, kUserData };
    static constexpr std::uint32_t kSourceChanges = 1, kUserDataChanges = 2, kAngleChanges = 4,
                                   kClassChanges = 8, kIntensityChanges = 16, kFlagsChange = 32;

    static void read_byte(ArithmeticDecoder& decoder, SymbolModels& models, std::uint8_t& byte) {
        byte = static_cast<std::uint8_t>(decoder.symbol(models[byte]));
    }

    void read_changes(ArithmeticDecoder& decoder, std::uint32_t changes, std::size_t context) {
        std::uint16_t& usual = intensities_[context];
        if ((changes & kIntensityChanges) != 0)
            usual = static_cast<std::uint16_t>(
                intensity_decoder_.read(decoder, usual, std::min<std::size_t>(context, 3)));
        intensity_ = usual;
        if ((changes & kClassChanges) != 0) read_byte(decoder, class_models_, bytes_[kClass]);
        if ((changes & kAngleChanges) != 0) {
            const std::size_t direction = bytes_[kFlags] >> 6 & 1U;
            const std::uint32_t step = decoder.symbol(angle_models_[direction]);
            bytes_[kAngle] = static_cast<std::uint8_t>(bytes_[kAngle] + step);
        }
        if ((changes & kUserDataChanges) != 0)
            read_byte(decoder, user_data_models_, bytes_[kUserData]);
        if ((changes & kSourceChanges) != 0)
            source_id_ = static_cast<std::uint16_t>(source_decoder_.read(decoder, source_id_));
    }

    void read_position(ArithmeticDecoder& decoder, std::size_t context, bool is_single,
                       std::size_t level) {
        const auto step = [&](std::size_t k, IntegerDecoder& steps, std::size_t step_context) {
            RunningMedian& median = medians_[k][context];
            const std::int32_t d = steps.read(decoder, median.value(), step_context);
            median.add(d);
            position_[k] = static_cast<std::int32_t>(static_cast<std::uint32_t>(position_[k]) +
                                                     static_cast<std::uint32_t>(d));
        };
        step(0, x_steps_, is_single ? 1 : 0);
        step(1, y_steps_, size_context(is_single, x_steps_.num_last_bits(), 20));
        const std::uint32_t num_bits = (x_steps_.num_last_bits() + y_steps_.num_last_bits()) / 2;
        position_[2] =
            heights_decoder_.read(decoder, heights_[level], size_context(is_single, num_bits, 18));
        heights_[level] = position_[2];
    }

    void store(std::byte* to) const {
        for (std::size_t k = 0; k < 3; ++k) store_value(to + 4 * k, position_[k]);
        store_value(to + 12, intensity_);
        for (std::size_t k = 0; k < 4; ++k) store_value(to + 14 + k, bytes_[k]);
        store_value(to + 18, source_id_);
    }

    std::array<std::int32_t, 3> position_{};
    std::array<std::uint8_t, 4> bytes_{};
    std::uint16_t intensity_ = 0, source_id_ = 0;  // the first intensity is not remembered
    std::array<std::uint16_t, 16> intensities_{};
    std::array<std::array<RunningMedian, 16>, 2> medians_;
    std::array<std::int32_t, 8> heights_{};
    SymbolModel changes_{64};
    SymbolModels flag_models_{256, 256}, class_models_{256, 256}, user_data_models_{256, 256},
        angle_models_{2, 256};
    IntegerDecoder intensity_decoder_{16, 4}, source_decoder_{16}, x_steps_{32, 2},
        y_steps_{32, 22}, heights_decoder_{32, 20};
};

class GpsTimeItem : public Item {
 public:
    void begin(const std::byte* first) override {
        times_.emplace(load_value<std::uint64_t>(first), true);
    }
    bool read(ArithmeticDecoder& decoder, std::byte* to) override {
        if (!times_->read(decoder)) return false;
        store_value(to, times_->value());
        return true;
    }

 private:
    std::optional<GpsTimes> times_;
};

class RgbItem : public Item {
 public:
    void begin(const std::byte* first) override { last_ = load_value<RawRgb>(first); }
    bool read(ArithmeticDecoder& decoder, std::byte* to) override {
        last_ = decoder_.read(decoder, last_);
        store_value(to, last_);
        return true;
    }

 private:
    RawRgb last_{};
    RgbDecoder decoder_;
};

class BytesItem : public Item {
 public:
    explicit BytesItem(std::size_t num_bytes) : last_(num_bytes), models_(num_bytes, 256) {}
    void begin(const std::byte* first) override { std::memcpy(last_.data(), first, last_.size()); }
    bool read(ArithmeticDecoder& decoder, std::byte* to) override {
        for (std::size_t k = 0; k < last_.size(); ++k)
            last_[k] = static_cast<std::uint8_t>(last_[k] + decoder.symbol(models_[k]));
        std::memcpy(to, last_.data(), last_.size());
        return true;
    }

 private:
    std::vector<std::uint8_t> last_;
    SymbolModels models_;
};

std::unique_ptr<Item> make_item(const LazItem& item) {
    switch (item.kind) {
        case LazItemKind::kPoint10:
            return std::make_unique<Point10Item>();
        case LazItemKind::kGpsTime:
            return std::make_unique<GpsTimeItem>();
        case LazItemKind::kRgb:
            return std::make_unique<RgbItem>();
        default:
            return std::make_unique<BytesItem>(item.num_bytes);
    }
}

}  // namespace

std::size_t record_bytes(std::span<const LazItem> items) {
    std::size_t sum = 0;
    for (const LazItem& item : items) sum += item.num_bytes;
    return sum;
}

std::optional<std::size_t> unpack_pointwise(std::span<const std::byte> bytes,
                                            std::span<const LazItem> items,
                                            std::span<std::byte> records) {
    const std::size_t stride = record_bytes(items);
    if (records.empty()) return 0;
    if (bytes.size() < stride) return std::nullopt;
    std::memcpy(records.data(), bytes.data(), stride);
    std::vector<std::unique_ptr<Item>> readers;
    std::size_t at = 0;
    for (const LazItem& item : items) {
        readers.push_back(make_item(item));
        readers.back()->begin(bytes.data() + at);
        at += item.num_bytes;
    }
    ArithmeticDecoder decoder(bytes.subspan(stride));
    for (std::size_t row = stride; row < records.size(); row += stride) {
        std::byte* to = records.data() + row;
        for (std::size_t k = 0; k < items.size(); ++k) {
            if (!readers[k]->read(decoder, to)) return std::nullopt;
            to += items[k].num_bytes;
        }
        if (decoder.is_overrun()) return std::nullopt;
    }
    return stride + decoder.num_read();
}

}  // namespace pointbake
