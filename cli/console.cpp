#include "console.h"

#include <unistd.h>

#include <array>
#include <cstdio>

namespace pointbake::cli {
namespace {

ProgressMode choose_progress(int verbosity, std::optional<ProgressMode> asked) {
    if (asked) return *asked;
    return verbosity >= 0 && isatty(STDERR_FILENO) ? ProgressMode::kBar : ProgressMode::kNone;
}

/// Where nobody listens the work goes on all the same.
void print_line(std::string_view prefix, std::string_view text) {
    const std::string line = fmt::format("{}{}\n", prefix, text);
    std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace

Console::Console(int verbosity, std::optional<ProgressMode> progress)
    : verbosity_(verbosity), bar_(choose_progress(verbosity, progress)) {}

void Console::print(int least_verbosity, std::string_view prefix, std::string_view text) {
    if (verbosity_ < least_verbosity) return;
    const std::lock_guard lock(mutex_);
    bar_.clear();
    print_line(prefix, text);
}

void Console::warning(std::string_view text) { print(-1, "pointbake: warning: ", text); }
void Console::summary(std::string_view text) { print(0, "", text); }

void Console::clear() {
    const std::lock_guard lock(mutex_);
    bar_.clear();
}

Context Console::context(int threads, std::stop_token stop) {
    Context context;
    context.threads = threads;
    context.stop = std::move(stop);
    context.progress = [this](std::string_view stage, double fraction) {
        const std::lock_guard lock(mutex_);
        bar_.report(stage, fraction);
    };
    context.log = [this](LogLevel level, std::string_view text) {
        if (level == LogLevel::kWarning) return warning(text);
        print(level == LogLevel::kInfo ? 1 : 2, "pointbake: ", text);
    };
    return context;
}

void print_error(std::string_view text) { print_line("pointbake: error: ", text); }

void print_data(std::string_view text) {
    const bool is_written =
        std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
    if (!is_written) fail(ErrorCode::kOutput, "standard output cannot be written");
}

std::string grouped(std::uint64_t value) {
    std::string text = fmt::format("{}", value);
    for (std::size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, 1, ',');
    return text;
}

std::string bytes_text(std::uint64_t bytes) {
    if (bytes < 1000) return fmt::format("{} bytes", bytes);
    static constexpr std::array<std::string_view, 4> units = {"kB", "MB", "GB", "TB"};
    double value = static_cast<double>(bytes) / 1000.0;
    std::size_t unit = 0;
    while (value >= 1000.0 && unit + 1 < units.size()) {
        value /= 1000.0;
        ++unit;
    }
    return fmt::format("{:.{}f} {}", value, value < 10.0 ? 1 : 0, units[unit]);
}

std::string counted(std::uint64_t count, std::string_view noun) {
    return fmt::format("{} {}{}", grouped(count), noun, count == 1 ? "" : "s");
}

}  // namespace pointbake::cli
