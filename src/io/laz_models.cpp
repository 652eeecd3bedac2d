#include "io/laz_models.h"

#include <algorithm>

namespace pointbake {
namespace {

// A step is coded as a multiple of the last one, from -10 to 500 times it, plus a rest.
constexpr int kMostTimes = 500, kLeastTimes = -10;
constexpr std::uint32_t kNewScan = kMostTimes - kLeastTimes + 1;

int byte_of(std::uint16_t value, int which) { return value >> (8 * which) & 255; }

}  // namespace

void RunningMedian::add(std::int32_t v) {
    const std::int32_t median = sorted_[2];
    if (drops_largest_) {
        std::size_t i = 4;
        for (; i > 0 && v < sorted_[i - 1]; --i) sorted_[i] = sorted_[i - 1];
        sorted_[i] = v;
        drops_largest_ = v < median;
    } else {
        std::size_t i = 0;
        for (; i < 4 && sorted_[i + 1] < v; ++i) sorted_[i] = sorted_[i + 1];
        sorted_[i] = v;
        drops_largest_ = v <= median;
    }
}

GpsTimes::GpsTimes(std::uint64_t first, bool is_always_coded)
    : is_always_coded_(is_always_coded),
      first_codes_(is_always_coded ? 6 : 5),
      next_codes_(kNewScan + (is_always_coded ? 5 : 4)) {
    times_[0] = first;
}

bool GpsTimes::read(ArithmeticDecoder& decoder) {
    // An encoder switches once and then has a step; damaged bytes could switch for ever.
    constexpr int kMostSwitches = 4;
    for (int i = 0; i <= kMostSwitches; ++i) {
        const Step step = differences_[last_] == 0 ? read_first(decoder) : read_next(decoder);
        if (step == Step::kDone) return true;
    }
    return false;
}

/// After a time that begins a scan or did not change.
GpsTimes::Step GpsTimes::read_first(ArithmeticDecoder& decoder) {
    std::uint32_t code = decoder.symbol(first_codes_);
    if (is_always_coded_ && code-- == 0) return Step::kDone;
    if (code == 0) {
        differences_[last_] = steps_.read(decoder, 0, 0);
        num_extreme_[last_] = 0;
        advance(differences_[last_]);
        return Step::kDone;
    }
    if (code == 1) {
        start_scan(decoder);
        return Step::kDone;
    }
    switch_scan(code - 1);
    return Step::kSwitched;
}

GpsTimes::Step GpsTimes::read_next(ArithmeticDecoder& decoder) {
    std::uint32_t code = decoder.symbol(next_codes_);
    if (is_always_coded_ && code == kNewScan) return Step::kDone;  // unchanged
    if (is_always_coded_ && code > kNewScan) --code;
    if (code == kNewScan) {
        start_scan(decoder);
        return Step::kDone;
    }
    if (code > kNewScan) {
        switch_scan(code - kNewScan);
        return Step::kSwitched;
    }
    int times = static_cast<int>(code);
    if (times > kMostTimes) times = kMostTimes - times;
    const auto expected = static_cast<std::int32_t>(
        static_cast<std::uint32_t>(times) * static_cast<std::uint32_t>(differences_[last_]));
    std::size_t context = 5;
    if (times == 1)
        context = 1;
    else if (times == 0)
        context = 7;
    else if (times == kMostTimes)
        context = 4;
    else if (times == kLeastTimes)
        context = 6;
    else if (times > 0)
        context = times < 10 ? 2 : 3;
    const std::int32_t difference = steps_.read(decoder, expected, context);
    if (times == 1) num_extreme_[last_] = 0;
    if (times == 0 || times == kMostTimes || times == kLeastTimes) count_extreme(difference);
    advance(difference);
    return Step::kDone;
}

void GpsTimes::start_scan(ArithmeticDecoder& decoder) {
    newest_ = (newest_ + 1) & 3U;
    const auto upper = steps_.read(decoder, static_cast<std::int32_t>(times_[last_] >> 32), 8);
    times_[newest_] = std::uint64_t{static_cast<std::uint32_t>(upper)} << 32 | decoder.bits(32);
    last_ = newest_;
    differences_[last_] = 0;
    num_extreme_[last_] = 0;
}

void GpsTimes::advance(std::int32_t difference) {
    times_[last_] += static_cast<std::uint64_t>(std::int64_t{difference});
}

/// Four of them in a row are the usual step from now on.
void GpsTimes::count_extreme(std::int32_t difference) {
    if (++num_extreme_[last_] <= 3) return;
    num_extreme_[last_] = 0;
    differences_[last_] = difference;
}

/// Byte `which` (0 and 1 red, 2 and 3 green, 4 and 5 blue; lower before upper), if it changed.
std::uint32_t RgbDecoder::read_byte(ArithmeticDecoder& decoder, std::uint32_t changes,
                                    std::size_t which, std::uint32_t last, int difference) {
    if ((changes >> which & 1U) == 0) return last;
    const auto expected = std::clamp(static_cast<int>(last) + difference, 0, 255);
    return (decoder.symbol(bytes_[which]) + static_cast<std::uint32_t>(expected)) & 255U;
}

RawRgb RgbDecoder::read(ArithmeticDecoder& decoder, const RawRgb& last) {
    const std::uint32_t changes = decoder.symbol(changes_);
    const auto byte = [&](std::size_t channel, int upper, int difference) {
        return static_cast<int>(
            read_byte(decoder, changes, 2 * channel + static_cast<std::size_t>(upper),
                      static_cast<std::uint32_t>(byte_of(last[channel], upper)), difference));
    };
    const auto joined = [](int lower, int upper) {
        return static_cast<std::uint16_t>(upper << 8 | lower);
    };
    const int red_lower = byte(0, 0, 0), red_upper = byte(0, 1, 0);
    const std::uint16_t red = joined(red_lower, red_upper);
    constexpr std::uint32_t kIsColored = 64;
    if ((changes & kIsColored) == 0) return {red, red, red};  // grey

    // Green is expected to change as red did, blue as the mean of both; lower bytes come first.
    std::array<int, 2> green{}, blue{};
    for (const int upper : {0, 1}) {
        const int red_change = (upper == 0 ? red_lower : red_upper) - byte_of(last[0], upper);
        const auto k = static_cast<std::size_t>(upper);
        green[k] = byte(1, upper, red_change);
        blue[k] = byte(2, upper, (red_change + green[k] - byte_of(last[1], upper)) / 2);
    }
    return {red, joined(green[0], green[1]), joined(blue[0], blue[1])};
}

std::size_t return_level(std::uint32_t n, std::uint32_t r) {
    return std::min(n > r ? n - r : r - n, 7U);
}

std::size_t size_context(bool is_single, std::uint32_t num_bits, std::uint32_t most) {
    return (is_single ? 1U : 0U) + (num_bits < most ? num_bits & ~1U : most);
}

}  // namespace pointbake
