#include "progress_bar.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>

namespace pointbake::cli {
namespace {

/// Usual shares of a conversion's time, measured on a scan of 134 345 points on two threads.
struct StageShare {
    std::string_view stage;
    double begin, end;
};
constexpr std::array<StageShare, 6> kStageShares = {{{"load", 0.0, 0.02},
                                                     {"attributes", 0.02, 0.06},
                                                     {"reconstruct", 0.06, 0.42},
                                                     {"simplify", 0.42, 0.75},
                                                     {"texture", 0.75, 0.98},
                                                     {"write", 0.98, 1.0}}};

constexpr double kSecondsBetweenDrawings = 0.1;
// Before this much is done a remaining time would jump about.
constexpr double kLeastDoneForEstimate = 0.03;
constexpr int kTextColumns = 36;  // stage, per cent and remaining time beside the bar
constexpr int kWidestBar = 40;

int terminal_columns() {
    winsize size{};
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

std::string minutes(double seconds) {
    if (seconds < 0.0) return "";
    const auto whole = static_cast<long>(seconds + 0.5);
    return fmt::format("{}:{:02} left", whole / 60, whole % 60);
}

void print(const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), stderr);
    std::fflush(stderr);
}

}  // namespace

void ProgressEstimate::report(std::string_view stage, double fraction) {
    for (const StageShare& share : kStageShares) {
        if (share.stage != stage) continue;
        const double here =
            share.begin + (share.end - share.begin) * std::clamp(fraction, 0.0, 1.0);
        total_ = std::max(total_, here);
    }
}

double ProgressEstimate::seconds_left(double elapsed) const {
    if (total_ < kLeastDoneForEstimate) return -1.0;
    return elapsed * (1.0 - total_) / total_;
}

ProgressBar::ProgressBar(ProgressMode mode) : mode_(mode) {}

void ProgressBar::report(std::string_view stage, double fraction) {
    if (mode_ == ProgressMode::kNone) return;
    estimate_.report(stage, fraction);
    const Clock::time_point now = Clock::now();
    const bool is_due =
        std::chrono::duration<double>(now - last_drawn_).count() >= kSecondsBetweenDrawings;
    // Begin and end of a stage are always told to programs; people need no flicker.
    const bool is_edge = mode_ == ProgressMode::kJson &&
                         (stage != last_stage_ || (fraction >= 1.0 && fraction > last_fraction_));
    if (!is_due && !is_edge) return;
    last_drawn_ = now;
    last_stage_ = stage;
    last_fraction_ = fraction;
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    if (mode_ == ProgressMode::kJson)
        print_json(stage, fraction, elapsed);
    else
        draw(stage, elapsed);
}

void ProgressBar::draw(std::string_view stage, double elapsed) {
    const int width = std::clamp(terminal_columns() - kTextColumns, 0, kWidestBar);
    const int done = static_cast<int>(estimate_.total() * width);
    print(fmt::format("\r\033[K{:<12} [{:#<{}}{:-<{}}] {:3.0f}% {}", stage, "", done, "",
                      width - done, 100.0 * estimate_.total(),
                      minutes(estimate_.seconds_left(elapsed))));
    is_drawn_ = true;
}

void ProgressBar::print_json(std::string_view stage, double fraction, double elapsed) {
    const double left = estimate_.seconds_left(elapsed);
    print(
        fmt::format("{{\"stage\": {}, \"fraction\": {:.4f}, \"total\": {:.4f}, \"seconds\": "
                    "{:.2f}, \"seconds_left\": {}}}\n",
                    json_string(stage), fraction, estimate_.total(), elapsed,
                    left < 0.0 ? "null" : fmt::format("{:.1f}", left)));
}

void ProgressBar::clear() {
    if (!is_drawn_) return;
    print("\r\033[K");
    is_drawn_ = false;
}

}  // namespace pointbake::cli
