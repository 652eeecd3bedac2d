// What a run shows of its progress on stderr: a bar with stage, share and remaining time, or one
// JSON object per line.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "run_options.h"

namespace pointbake::cli {

/// How far a conversion is: each stage's usual share of the time, so that the bar and the remaining
/// time speak of the whole.
class ProgressEstimate {
 public:
    /// A stage's report. Unknown stages (parts of known ones) change nothing.
    void report(std::string_view stage, double fraction);
    /// Share of the whole work that is done, in [0, 1].
    double total() const { return total_; }
    /// Seconds left after `elapsed` of them; negative: too early to tell.
    double seconds_left(double elapsed) const;

 private:
    double total_ = 0.0;
};

/// Draws at most ten times a second. Not thread-safe: progress comes on one thread.
class ProgressBar {
 public:
    explicit ProgressBar(ProgressMode mode);
    void report(std::string_view stage, double fraction);
    /// Takes the bar off the terminal, so that a message can be printed.
    void clear();

 private:
    using Clock = std::chrono::steady_clock;

    void draw(std::string_view stage, double elapsed);
    void print_json(std::string_view stage, double fraction, double elapsed);

    ProgressMode mode_;
    ProgressEstimate estimate_;
    Clock::time_point start_ = Clock::now();
    Clock::time_point last_drawn_{};
    std::string last_stage_;
    double last_fraction_ = -1.0;
    bool is_drawn_ = false;
};

}  // namespace pointbake::cli
