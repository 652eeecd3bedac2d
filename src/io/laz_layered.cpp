// The compression of point formats 6 to 10. A chunk is its first point, not compressed; the number
// of its points; the sizes of its layers; the layers. Layers of no bytes never change. Each of up
// to four scanner channels has contexts of its own.
#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

#include "io/laz_chunk.h"
#include "io/laz_models.h"
#include "io/number_type.h"

namespace pointbake {
namespace {

constexpr std::size_t kNumChannels = 4;
constexpr std::size_t kSizeBytes = 4;  // of a layer's size, and of the number of points

template <class T>
void store_value(std::byte* to, T value) {
    std::memcpy(to, &value, sizeof(T));
}

/// The bytes of one kind of value, which may never change.
struct Layer {
    ArithmeticDecoder decoder;
    bool changes = false;
    bool is_skipped = false;

    explicit Layer(std::span<const std::byte> bytes) : decoder(bytes), changes(!bytes.empty()) {}
    bool is_overrun() const { return changes && !is_skipped && decoder.is_overrun(); }
};

std::size_t num_layers(const LazItem& item) {
    switch (item.kind) {
        case LazItemKind::kPoint14:
            return 9;
        case LazItemKind::kRgbNir14:
            return 2;
        case LazItemKind::kBytes14:
            return item.num_bytes;
        default:
            return 1;
    }
}

class Item {
 public:
    virtual ~Item() = default;
    /// `channel` is the scanner channel of the point; the item of the point itself sets it.
    virtual void begin(const std::byte* first, std::size_t& channel) = 0;
    virtual bool read(std::byte* to, std::size_t& channel) = 0;
};

// LASzip's contexts for return r (column) of n (row); those that cannot be have one, too.
constexpr std::array<const char*, 16> kReturnContexts{
    "0123453445555555", "1013333333333333", "2124444444433333", "3345444444444444",
    "4344544444444444", "5344454444444444", "3344445444444444", "4344444544444444",
    "4344444454444444", "5344444445444444", "5344444444544444", "5334444444455444",
    "5334444444455544", "5334444444445554", "5334444444444555", "5334444444444455"};

std::size_t return_context(std::uint32_t n, std::uint32_t r) {
    return static_cast<std::size_t>(kReturnContexts[n][r] - '0');
}

struct Point14 {
    std::array<std::int32_t, 3> position{};
    std::uint16_t intensity = 0;
    std::uint32_t r = 0, n = 0;  ///< return r of n
    std::uint32_t flags = 0;     ///< 4 bits of class flags, direction, edge; without the channel
    std::uint8_t classification = 0, user_data = 0;
    std::uint16_t angle = 0, source_id = 0;
    std::uint64_t gps_time = 0;
    bool has_new_time = false;  ///< other than the point before
};

Point14 load_point(const std::byte* from, std::size_t& channel) {
    Point14 p;
    for (std::size_t k = 0; k < 3; ++k) p.position[k] = load_value<std::int32_t>(from + 4 * k);
    p.intensity = load_value<std::uint16_t>(from + 12);
    const auto returns = load_value<std::uint8_t>(from + 14);
    p.r = returns & 15U;
    p.n = returns >> 4;
    const auto flags = load_value<std::uint8_t>(from + 15);
    p.flags = (flags & 15U) | (flags >> 6 << 4);
    channel = flags >> 4 & 3U;
    p.classification = load_value<std::uint8_t>(from + 16);
    p.user_data = load_value<std::uint8_t>(from + 17);
    p.angle = load_value<std::uint16_t>(from + 18);
    p.source_id = load_value<std::uint16_t>(from + 20);
    p.gps_time = load_value<std::uint64_t>(from + 22);
    return p;
}

void store_point(const Point14& p, std::size_t channel, std::byte* to) {
    for (std::size_t k = 0; k < 3; ++k) store_value(to + 4 * k, p.position[k]);
    store_value(to + 12, p.intensity);
    store_value(to + 14, static_cast<std::uint8_t>(p.r | p.n << 4));
    store_value(to + 15, static_cast<std::uint8_t>((p.flags & 15U) | channel << 4 |
                                                   (p.flags >> 4 & 3U) << 6));
    store_value(to + 16, p.classification);
    store_value(to + 17, p.user_data);
    store_value(to + 18, p.angle);
    store_value(to + 20, p.source_id);
    store_value(to + 22, p.gps_time);
}

/// What a scanner channel remembers.
struct PointContext {
    explicit PointContext(const Point14& last_point)
        : last(last_point), times(last_point.gps_time, false) {
        last.has_new_time = false;
        intensities.fill(last.intensity);
        heights.fill(last.position[2]);
    }

    Point14 last;
    std::array<std::uint16_t, 8> intensities{};
    std::array<std::array<RunningMedian, 12>, 2> medians;
    std::array<std::int32_t, 8> heights{};
    SymbolModels changes{8, 128}, channels{1, 3}, num_returns{16, 16}, returns{16, 16},
        returns_at_same_time{1, 13}, classes{64, 256}, flags{64, 64}, user_data{64, 256};
    IntegerDecoder x_steps{32, 2}, y_steps{32, 22}, z{32, 20}, intensity{16, 4}, angle{16, 2},
        source_id{16};
    GpsTimes times;
};

class PointItem : public Item {
 public:
    static constexpr std::size_t kBytes = 30;

    PointItem(std::span<Layer> layers, bool is_version_3)
        : layers_(layers), is_version_3_(is_version_3) {}

    void begin(const std::byte* first, std::size_t& channel) override {
        const Point14 point = load_point(first, channel);
        channel_ = channel;
        contexts_[channel].emplace(point);
    }

    bool read(std::byte* to, std::size_t& channel) override {
        ArithmeticDecoder& decoder = layers_[kPositions].decoder;
        const Point14& before = contexts_[channel_]->last;
        const std::uint32_t changes = decoder.symbol(
            contexts_[channel_]
                ->changes[(before.r == 1 ? 1U : 0U) | (before.r >= before.n ? 2U : 0U) |
                          (before.has_new_time ? 4U : 0U)]);
        if ((changes & kChannelChanges) != 0) change_channel(decoder);
        PointContext& c = *contexts_[channel_];
        const bool has_new_time = (changes & kTimeChanges) != 0;
        read_returns(c, changes, has_new_time);
        read_position(c, has_new_time);
        read_values(c, changes, has_new_time);
        c.last.has_new_time = has_new_time;
        if (has_new_time && layers_[kTimes].changes) {
            if (!c.times.read(layers_[kTimes].decoder)) return false;
            c.last.gps_time = c.times.value();
        }
        // In version 3 the other parts are told the channel where it changes only.
        const bool is_told = !is_version_3_ || (changes & kChannelChanges) != 0;
        channel = is_told ? channel_ : 0;
        store_point(c.last, channel_, to);
        return true;
    }

 private:
    enum LayerOf : std::size_t {
        kPositions,  // with channel and returns
        kHeights,
        kClasses,
        kFlags,
        kIntensities,
        kAngles,
        kUserData,
        kSources,
        kTimes
    };
    static constexpr std::uint32_t kNumReturnsChanges = 4, kAngleChanges = 8, kTimeChanges = 16,
                                   kSourceChanges = 32, kChannelChanges = 64;

    void change_channel(ArithmeticDecoder& decoder) {
        const PointContext& from = *contexts_[channel_];
        const std::size_t step = decoder.symbol(contexts_[channel_]->channels[0]) + 1;
        channel_ = (channel_ + step) % kNumChannels;
        if (!contexts_[channel_]) contexts_[channel_].emplace(from.last);
    }

    void read_returns(PointContext& c, std::uint32_t changes, bool has_new_time) {
        ArithmeticDecoder& decoder = layers_[kPositions].decoder;
        Point14& p = c.last;
        if ((changes & kNumReturnsChanges) != 0) p.n = decoder.symbol(c.num_returns[p.n]);
        switch (changes & 3U) {
            case 0:
                break;
            case 1:
                p.r = (p.r + 1) & 15U;
                break;
            case 2:
                p.r = (p.r + 15) & 15U;
                break;
            default:
                p.r = has_new_time ? decoder.symbol(c.returns[p.r])
                                   : (p.r + decoder.symbol(c.returns_at_same_time[0]) + 2) & 15U;
        }
    }

    void read_position(PointContext& c, bool has_new_time) {
        ArithmeticDecoder& decoder = layers_[kPositions].decoder;
        Point14& p = c.last;
        const std::size_t context = return_context(p.n, p.r) * 2 + (has_new_time ? 1 : 0);
        const bool is_single = p.n == 1;
        const auto step = [&](std::size_t k, IntegerDecoder& steps, std::size_t step_context) {
            RunningMedian& median = c.medians[k][context];
            const std::int32_t d = steps.read(decoder, median.value(), step_context);
            median.add(d);
            p.position[k] = static_cast<std::int32_t>(static_cast<std::uint32_t>(p.position[k]) +
                                                      static_cast<std::uint32_t>(d));
        };
        step(0, c.x_steps, is_single ? 1 : 0);
        step(1, c.y_steps, size_context(is_single, c.x_steps.num_last_bits(), 20));
        if (!layers_[kHeights].changes) return;
        const std::uint32_t num_bits = (c.x_steps.num_last_bits() + c.y_steps.num_last_bits()) / 2;
        std::int32_t& height = c.heights[return_level(p.n, p.r)];
        height = c.z.read(layers_[kHeights].decoder, height, size_context(is_single, num_bits, 18));
        p.position[2] = height;
    }

    void read_values(PointContext& c, std::uint32_t changes, bool has_new_time) {
        Point14& p = c.last;
        const std::size_t place = (p.r == 1 ? 2U : 0U) | (p.r >= p.n ? 1U : 0U);
        const std::size_t new_time = has_new_time ? 1 : 0;
        if (layers_[kClasses].changes)
            p.classification = static_cast<std::uint8_t>(layers_[kClasses].decoder.symbol(
                c.classes[(p.classification & 31U) * 2 + (place == 3 ? 1 : 0)]));
        if (layers_[kFlags].changes) p.flags = layers_[kFlags].decoder.symbol(c.flags[p.flags]);
        if (layers_[kIntensities].changes) {
            std::uint16_t& usual = c.intensities[place * 2 + new_time];
            usual = static_cast<std::uint16_t>(
                c.intensity.read(layers_[kIntensities].decoder, usual, place));
            p.intensity = usual;
        }
        if (layers_[kAngles].changes && (changes & kAngleChanges) != 0)
            p.angle = static_cast<std::uint16_t>(
                c.angle.read(layers_[kAngles].decoder, p.angle, new_time));
        if (layers_[kUserData].changes)
            p.user_data = static_cast<std::uint8_t>(
                layers_[kUserData].decoder.symbol(c.user_data[p.user_data / 4U]));
        if (layers_[kSources].changes && (changes & kSourceChanges) != 0)
            p.source_id = static_cast<std::uint16_t>(
                c.source_id.read(layers_[kSources].decoder, p.source_id));
    }

    std::span<Layer> layers_;
    bool is_version_3_;
    std::size_t channel_ = 0;
    std::array<std::optional<PointContext>, kNumChannels> contexts_;
};

/// Values of the other parts per scanner channel. In version 3 a point of another channel than the
/// one before is compared with that one's values, which are then what is brought up to date.
template <class Value>
class ChannelValues {
 public:
    explicit ChannelValues(bool is_version_3) : is_version_3_(is_version_3) {}

    void begin(const Value& first, std::size_t channel) {
        current_ = channel;
        values_[channel] = first;
        is_used_[channel] = true;
    }
    Value& last(std::size_t channel) {
        std::size_t at = is_version_3_ ? current_ : channel;
        if (!is_used_[channel]) {
            values_[channel] = values_[current_];
            is_used_[channel] = true;
            at = channel;
        }
        current_ = channel;
        return values_[at];
    }

 private:
    bool is_version_3_;
    std::array<Value, kNumChannels> values_{};
    std::array<bool, kNumChannels> is_used_{};
    std::size_t current_ = 0;
};

class Rgb14Item : public Item {
 public:
    Rgb14Item(Layer& layer, bool is_version_3) : layer_(layer), values_(is_version_3) {}
    void begin(const std::byte* first, std::size_t& channel) override {
        values_.begin(load_value<RawRgb>(first), channel);
    }
    bool read(std::byte* to, std::size_t& channel) override {
        RawRgb& last = values_.last(channel);
        if (layer_.changes) last = decoders_[channel].read(layer_.decoder, last);
        store_value(to, last);
        return true;
    }

 private:
    Layer& layer_;
    ChannelValues<RawRgb> values_;
    std::array<RgbDecoder, kNumChannels> decoders_;
};

class RgbNirItem : public Item {
 public:
    static constexpr std::size_t kNirAt = 6;

    RgbNirItem(Layer& rgb, Layer& nir, bool is_version_3)
        : rgb_(rgb, is_version_3), layer_(nir), values_(is_version_3) {}
    void begin(const std::byte* first, std::size_t& channel) override {
        rgb_.begin(first, channel);
        values_.begin(load_value<std::uint16_t>(first + kNirAt), channel);
    }
    bool read(std::byte* to, std::size_t& channel) override {
        rgb_.read(to, channel);
        std::uint16_t& last = values_.last(channel);
        if (layer_.changes) {
            const std::uint32_t changes = layer_.decoder.symbol(changes_[channel]);
            for (unsigned k = 0; k < 2; ++k) {
                if ((changes >> k & 1U) == 0) continue;
                const std::uint32_t step = layer_.decoder.symbol(bytes_[2 * channel + k]);
                const std::uint32_t byte = ((last >> (8 * k)) + step) & 255U;
                last = static_cast<std::uint16_t>((last & ~(255U << (8 * k))) | byte << (8 * k));
            }
        }
        store_value(to + kNirAt, last);
        return true;
    }

 private:
    Rgb14Item rgb_;
    Layer& layer_;
    ChannelValues<std::uint16_t> values_;
    SymbolModels changes_{kNumChannels, 4}, bytes_{2 * kNumChannels, 256};
};

class Bytes14Item : public Item {
 public:
    Bytes14Item(std::span<Layer> layers, bool is_version_3)
        : layers_(layers), values_(is_version_3), models_(kNumChannels * layers.size(), 256) {}
    void begin(const std::byte* first, std::size_t& channel) override {
        std::vector<std::uint8_t> bytes(layers_.size());
        std::memcpy(bytes.data(), first, bytes.size());
        values_.begin(bytes, channel);
    }
    bool read(std::byte* to, std::size_t& channel) override {
        std::vector<std::uint8_t>& last = values_.last(channel);
        for (std::size_t k = 0; k < last.size(); ++k)
            if (layers_[k].changes)
                last[k] = static_cast<std::uint8_t>(
                    last[k] + layers_[k].decoder.symbol(models_[channel * last.size() + k]));
        std::memcpy(to, last.data(), last.size());
        return true;
    }

 private:
    std::span<Layer> layers_;
    ChannelValues<std::vector<std::uint8_t>> values_;
    SymbolModels models_;
};

/// Where the wave packets would be: nothing here wants them, and their layer is their own.
class SkippedItem : public Item {
 public:
    void begin(const std::byte*, std::size_t&) override {}
    bool read(std::byte*, std::size_t&) override { return true; }
};

std::unique_ptr<Item> make_item(const LazItem& item, std::span<Layer> layers) {
    const bool is_version_3 = item.version == 3;
    switch (item.kind) {
        case LazItemKind::kPoint14:
            return std::make_unique<PointItem>(layers, is_version_3);
        case LazItemKind::kRgb14:
            return std::make_unique<Rgb14Item>(layers[0], is_version_3);
        case LazItemKind::kRgbNir14:
            return std::make_unique<RgbNirItem>(layers[0], layers[1], is_version_3);
        case LazItemKind::kBytes14:
            return std::make_unique<Bytes14Item>(layers, is_version_3);
        default:
            layers[0].is_skipped = true;
            return std::make_unique<SkippedItem>();
    }
}

std::size_t num_all_layers(std::span<const LazItem> items) {
    std::size_t sum = 0;
    for (const LazItem& item : items) sum += num_layers(item);
    return sum;
}

std::vector<Layer> split_layers(std::span<const std::byte> bytes, std::size_t sizes_at,
                                std::size_t num) {
    std::vector<Layer> layers;
    layers.reserve(num);
    std::size_t at = sizes_at + num * kSizeBytes;
    for (std::size_t i = 0; i < num; ++i) {
        const auto size = load_value<std::uint32_t>(bytes.data() + sizes_at + i * kSizeBytes);
        layers.emplace_back(bytes.subspan(at, size));
        at += size;
    }
    return layers;
}

}  // namespace

std::optional<LayeredSize> layered_size(std::span<const std::byte> bytes,
                                        std::span<const LazItem> items) {
    const std::size_t stride = record_bytes(items), num = num_all_layers(items);
    const std::size_t begin = stride + kSizeBytes * (1 + num);
    if (bytes.size() < begin) return std::nullopt;
    LayeredSize size{begin, load_value<std::uint32_t>(bytes.data() + stride)};
    for (std::size_t i = 0; i < num; ++i)
        size.num_bytes += load_value<std::uint32_t>(bytes.data() + stride + kSizeBytes * (1 + i));
    if (size.num_bytes > bytes.size()) return std::nullopt;
    return size;
}

std::optional<std::size_t> unpack_layered(std::span<const std::byte> bytes,
                                          std::span<const LazItem> items,
                                          std::span<std::byte> records) {
    if (records.empty()) return 0;
    const std::optional<LayeredSize> size = layered_size(bytes, items);
    if (!size) return std::nullopt;
    const std::size_t stride = record_bytes(items);
    std::vector<Layer> layers = split_layers(bytes, stride + kSizeBytes, num_all_layers(items));
    std::vector<std::unique_ptr<Item>> readers;
    std::span<Layer> rest = layers;
    std::size_t at = 0, channel = 0;
    for (const LazItem& item : items) {
        readers.push_back(make_item(item, rest.first(num_layers(item))));
        readers.back()->begin(bytes.data() + at, channel);
        rest = rest.subspan(num_layers(item));
        at += item.num_bytes;
    }
    std::memcpy(records.data(), bytes.data(), stride);
    for (std::size_t row = stride; row < records.size(); row += stride) {
        std::byte* to = records.data() + row;
        for (std::size_t k = 0; k < items.size(); ++k) {
            if (!readers[k]->read(to, channel)) return std::nullopt;
            to += items[k].num_bytes;
        }
        // This layer is never empty, however many points there are said to be.
        if (layers[0].decoder.is_overrun()) return std::nullopt;
    }
    if (std::ranges::any_of(layers, &Layer::is_overrun)) return std::nullopt;
    return static_cast<std::size_t>(size->num_bytes);
}

}  // namespace pointbake
