// Pull-push [Gortler96]: pulling averages the owned texels below a coarser one, pushing
// interpolates bilinearly from the level above into texels that nobody owns, and moves them so that
// their mean with the owned ones is what is above: then box-filtered mip levels show what is owned
// alone.
#include <algorithm>
#include <array>

#include "core/color.h"
#include "core/message.h"
#include "core/parallel.h"
#include "pointbake/atlas.h"

namespace pointbake {
namespace {

constexpr std::size_t kRowGrain = 32;
constexpr int kMaxChannels = 4;

struct Level {
    int width = 0, height = 0;
    std::vector<std::array<float, kMaxChannels>> values;
    std::vector<std::uint8_t> owned;
    std::vector<float> weights;  // owned texels of the image below each

    Level(int w, int h) : width(w), height(h) {
        const auto n = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
        values.resize(n);
        owned.resize(n);
        weights.resize(n);
    }
    std::size_t at(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }
};

using Value = std::array<float, kMaxChannels>;

// The last of two or four channels is alpha: not a light, so not decoded.
struct Decoder {
    std::array<float, 256> light{};
    int num_channels;
    int alpha;

    explicit Decoder(int channels)
        : num_channels(channels), alpha(channels % 2 == 0 ? channels - 1 : -1) {
        for (std::uint16_t v = 0; v < 256; ++v)
            light[v] = srgb_to_linear(static_cast<std::uint16_t>(v * 257));
    }
    void add(const std::uint8_t* texel, Value& sum) const {
        for (int c = 0; c < num_channels; ++c)
            sum[static_cast<std::size_t>(c)] +=
                c == alpha ? static_cast<float>(texel[c]) / 255.0F : light[texel[c]];
    }
    void encode(const Value& value, std::uint8_t* texel) const {
        for (int c = 0; c < num_channels; ++c) {
            const float v = value[static_cast<std::size_t>(c)];
            texel[c] =
                c == alpha ? static_cast<std::uint8_t>(255.0F * v + 0.5F) : linear_to_srgb8(v);
        }
    }
};

Level half(int width, int height) { return Level((width + 1) / 2, (height + 1) / 2); }

// Average of those of the four texels under (x, y) that are owned. add(index, sum) adds one.
template <class Owned, class Add>
void pull_texel(Level& to, int x, int y, int width, int height, Owned&& owned, Add&& add) {
    Value sum{};
    float count = 0.0F;
    for (int j = 2 * y; j < std::min(2 * y + 2, height); ++j) {
        for (int i = 2 * x; i < std::min(2 * x + 2, width); ++i) {
            const std::size_t from = static_cast<std::size_t>(j) * static_cast<std::size_t>(width) +
                                     static_cast<std::size_t>(i);
            if (owned[from] == 0) continue;
            count += add(from, sum);
        }
    }
    if (count == 0.0F) return;
    const std::size_t k = to.at(x, y);
    to.owned[k] = 1;
    to.weights[k] = count;
    const float scale = 1.0F / count;
    for (std::size_t c = 0; c < kMaxChannels; ++c) to.values[k][c] = sum[c] * scale;
}

// Value of the coarser level at texel (x, y) of the finer one: its texel's centre lies a quarter
// texel off.
Value interpolate(const Level& coarse, int x, int y) {
    const int x0 = x / 2, y0 = y / 2;
    const int x1 = std::clamp(x % 2 == 0 ? x0 - 1 : x0 + 1, 0, coarse.width - 1);
    const int y1 = std::clamp(y % 2 == 0 ? y0 - 1 : y0 + 1, 0, coarse.height - 1);
    const Value& a = coarse.values[coarse.at(x0, y0)];
    const Value& b = coarse.values[coarse.at(x1, y0)];
    const Value& c = coarse.values[coarse.at(x0, y1)];
    const Value& d = coarse.values[coarse.at(x1, y1)];
    Value out;
    for (std::size_t k = 0; k < kMaxChannels; ++k)
        out[k] = (9.0F * a[k] + 3.0F * (b[k] + c[k]) + d[k]) * 0.0625F;
    return out;
}

template <class Body>
void for_rows(const Context& context, int height, Body&& body) {
    parallel_for(context, static_cast<std::size_t>(height), kRowGrain,
                 [&](std::size_t begin, std::size_t end) {
                     for (std::size_t y = begin; y < end; ++y) body(static_cast<int>(y));
                 });
}

// The levels above the image; the last one has one texel.
std::vector<Level> pull(const Image& page, std::span<const std::uint8_t> owned,
                        const Decoder& decoder, const Context& context) {
    std::vector<Level> levels;
    levels.push_back(half(page.width, page.height));
    for_rows(context, levels[0].height, [&](int y) {
        for (int x = 0; x < levels[0].width; ++x)
            pull_texel(
                levels[0], x, y, page.width, page.height, owned, [&](std::size_t from, Value& sum) {
                    decoder.add(
                        page.pixels.data() + from * static_cast<std::size_t>(page.num_channels),
                        sum);
                    return 1.0F;
                });
    });
    while (levels.back().values.size() > 1) {
        levels.push_back(half(levels.back().width, levels.back().height));
        const Level& from = levels[levels.size() - 2];
        Level& to = levels.back();
        for_rows(context, to.height, [&](int y) {
            for (int x = 0; x < to.width; ++x)
                pull_texel(to, x, y, from.width, from.height, from.owned,
                           [&](std::size_t k, Value& sum) {
                               for (std::size_t c = 0; c < kMaxChannels; ++c)
                                   sum[c] += from.values[k][c] * from.weights[k];
                               return from.weights[k];
                           });
        });
    }
    return levels;
}

// Fills the free ones of the four texels below (x, y) of the coarser level: smoothly, and so that
// their mean is what is wanted there. own(i, j, value) tells whether a texel has a value.
template <class Own, class Set>
void push_block(const Level& coarse, int x, int y, int width, int height, Own&& own, Set&& set) {
    const Value& wanted = coarse.values[coarse.at(x, y)];
    std::array<Value, 4> values;
    std::array<bool, 4> is_free{};
    Value missing{};
    float count = 0.0F, num_free = 0.0F;
    for (int k = 0; k < 4; ++k) {
        const int i = 2 * x + k % 2, j = 2 * y + k / 2;
        if (i >= width || j >= height) continue;
        Value& v = values[static_cast<std::size_t>(k)];
        count += 1.0F;
        if (!own(i, j, v)) {
            v = interpolate(coarse, i, j);
            is_free[static_cast<std::size_t>(k)] = true;
            num_free += 1.0F;
        }
        for (std::size_t c = 0; c < kMaxChannels; ++c) missing[c] -= v[c];
    }
    if (num_free == 0.0F) return;
    for (std::size_t c = 0; c < kMaxChannels; ++c)
        missing[c] = (missing[c] + count * wanted[c]) / num_free;
    for (int k = 0; k < 4; ++k) {
        if (!is_free[static_cast<std::size_t>(k)]) continue;
        Value& v = values[static_cast<std::size_t>(k)];
        for (std::size_t c = 0; c < kMaxChannels; ++c)
            v[c] = std::clamp(v[c] + missing[c], 0.0F, 1.0F);
        set(2 * x + k % 2, 2 * y + k / 2, v);
    }
}

void push(std::vector<Level>& levels, const Context& context) {
    for (std::size_t l = levels.size() - 1; l-- > 0;) {
        Level& level = levels[l];
        const Level& coarse = levels[l + 1];
        for_rows(context, coarse.height, [&](int y) {
            for (int x = 0; x < coarse.width; ++x)
                push_block(
                    coarse, x, y, level.width, level.height,
                    [&](int i, int j, Value& value) {
                        value = level.values[level.at(i, j)];
                        return level.owned[level.at(i, j)] != 0;
                    },
                    [&](int i, int j, const Value& value) {
                        level.values[level.at(i, j)] = value;
                    });
        });
    }
}

}  // namespace

void fill_unowned_in_place(Image& page, std::span<const std::uint8_t> owned,
                           const Context& context) {
    const auto channels = static_cast<std::size_t>(page.num_channels);
    if (page.num_channels < 1 || page.num_channels > kMaxChannels ||
        page.pixels.size() != page.num_texels() * channels || owned.size() != page.num_texels())
        fail(ErrorCode::kInvalidInput,
             "a page of {} x {} texels with {} channels has {} bytes and {} ownership bytes; 1 to "
             "{} channels and one entry per texel are accepted",
             page.width, page.height, page.num_channels, page.pixels.size(), owned.size(),
             kMaxChannels);
    check_cancelled(context);
    if (page.num_texels() == 0) return;
    const Decoder decoder(page.num_channels);
    std::vector<Level> levels = pull(page, owned, decoder, context);
    if (levels.back().owned[0] == 0) return;
    push(levels, context);
    const auto texel = [&](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(page.width) +
               static_cast<std::size_t>(x);
    };
    for_rows(context, levels[0].height, [&](int y) {
        for (int x = 0; x < levels[0].width; ++x)
            push_block(
                levels[0], x, y, page.width, page.height,
                [&](int i, int j, Value& value) {
                    if (owned[texel(i, j)] == 0) return false;
                    value = {};
                    decoder.add(page.pixels.data() + texel(i, j) * channels, value);
                    return true;
                },
                [&](int i, int j, const Value& value) {
                    decoder.encode(value, page.pixels.data() + texel(i, j) * channels);
                });
    });
}

}  // namespace pointbake
