// What surrounds a run: threads, cancellation, progress, log. The last argument of every stage.
#pragma once

#include <functional>
#include <stop_token>
#include <string_view>

namespace pointbake {

enum class LogLevel { kDebug, kInfo, kWarning };

struct Context {
    int threads = 0;  ///< 0 = all cores
    std::stop_token stop =
        {};  ///< polled once per chunk of work; when set, stages throw Error{kCancelled}
    /// (stage, fraction in [0, 1]); called on the calling thread only, monotone within a stage
    std::function<void(std::string_view, double)> progress = {};
    /// one line per kind of message, never one per element
    std::function<void(LogLevel, std::string_view)> log = {};
};

}  // namespace pointbake
