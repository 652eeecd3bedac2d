// The backstop of --max-memory: a run that takes more than was predicted is stopped.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <thread>

namespace pointbake::cli {

/// Looks at the memory of the process every few milliseconds, as long as it lives.
class MemoryWatch {
 public:
    /// No bytes: no limit. `stop` is passed on.
    MemoryWatch(std::optional<std::uint64_t> most_bytes, const std::stop_token& stop);

    /// Told to stop when `stop` is, or when the limit is exceeded.
    std::stop_token token() const { return source_.get_token(); }
    bool is_exceeded() const { return is_exceeded_; }

 private:
    void watch(std::uint64_t most_bytes, const std::stop_token& ending);

    std::stop_source source_;
    std::atomic<bool> is_exceeded_ = false;
    std::stop_callback<std::function<void()>> passed_on_;
    std::jthread watcher_;
};

}  // namespace pointbake::cli
