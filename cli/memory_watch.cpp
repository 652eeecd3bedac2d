#include "memory_watch.h"

#include <chrono>

#include "core/memory.h"

namespace pointbake::cli {

MemoryWatch::MemoryWatch(std::optional<std::uint64_t> most_bytes, const std::stop_token& stop)
    : passed_on_(stop, [this] { source_.request_stop(); }) {
    if (most_bytes)
        watcher_ = std::jthread(
            [this, most = *most_bytes](const std::stop_token& ending) { watch(most, ending); });
}

void MemoryWatch::watch(std::uint64_t most_bytes, const std::stop_token& ending) {
    constexpr std::chrono::milliseconds kPoll{2};
    while (!ending.stop_requested()) {
        if (memory_bytes() > most_bytes) {
            is_exceeded_ = true;
            source_.request_stop();
            return;
        }
        std::this_thread::sleep_for(kPoll);
    }
}

}  // namespace pointbake::cli
