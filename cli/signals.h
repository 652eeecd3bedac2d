// Ctrl-C and its like end a run cleanly: the first one asks the library to stop, a second one kills
// the process.
#pragma once

#include <stop_token>
#include <thread>

namespace pointbake::cli {

/// Takes SIGINT, SIGTERM and SIGHUP as long as it lives. Must be made before any other thread,
/// which inherit the blocked signals; then only the watcher sees them and nothing runs inside a
/// signal handler.
class StopOnSignal {
 public:
    StopOnSignal();
    std::stop_token token() const { return source_.get_token(); }

 private:
    void watch(const std::stop_token& ending);

    std::stop_source source_;
    std::jthread watcher_;  // last: ends before the rest is destroyed
};

}  // namespace pointbake::cli
