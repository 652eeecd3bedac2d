// Everything that a run says to people: messages, the bar, the summary. All of it on stderr; stdout
// is for data.
#pragma once

#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "pointbake/context.h"
#include "progress_bar.h"

namespace pointbake::cli {

class Console {
 public:
    /// verbosity: -1 only warnings and errors, 0 with summary, 1 with the stages' lines, 2 all.
    Console(int verbosity, std::optional<ProgressMode> progress);
    ~Console() { clear(); }
    Console(const Console&) = delete;
    Console& operator=(const Console&) = delete;

    void warning(std::string_view text);
    void summary(std::string_view text);
    void clear();
    /// What the library is given: its lines and its progress come here.
    Context context(int threads, std::stop_token stop);

 private:
    void print(int least_verbosity, std::string_view prefix, std::string_view text);

    int verbosity_;
    ProgressBar bar_;
    std::mutex mutex_;  // log lines may come from any thread
};

void print_error(std::string_view text);
/// To stdout; throws Error{kOutput} if it cannot be written.
void print_data(std::string_view text);

/// 1234567 as "1,234,567".
std::string grouped(std::uint64_t value);
/// 3400000 bytes as "3.4 MB".
std::string bytes_text(std::uint64_t bytes);
/// "1 page", "2 pages".
std::string counted(std::uint64_t count, std::string_view noun);

}  // namespace pointbake::cli
