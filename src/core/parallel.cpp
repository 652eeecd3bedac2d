#include "core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

#include <thread>

#include "pointbake/error.h"

namespace pointbake {

int num_threads(const Context& context) {
    const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    // Far more threads than cores only wait for each other.
    constexpr int kAlwaysAllowed = 16, kMostPerCore = 4;
    if (context.threads > 0)
        return std::min(context.threads, std::max(kAlwaysAllowed, kMostPerCore * cores));
    return cores;
}

void allow_many_threads() {
    // More threads than cores must be allowed before the library below starts its first one, or it
    // complains on stderr.
    constexpr std::size_t kMost = 1024;
    static const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, kMost);
}

void check_cancelled(const Context& context) {
    if (context.stop.stop_requested()) throw Error(ErrorCode::kCancelled, "cancelled");
}

void parallel_chunks(const Context& context, std::size_t num_chunks,
                     const std::function<void(std::size_t)>& body) {
    const auto guarded = [&](std::size_t chunk) {
        check_cancelled(context);
        body(chunk);
    };
    const int threads = num_threads(context);
    if (threads == 1 || num_chunks < 2) {
        for (std::size_t chunk = 0; chunk < num_chunks; ++chunk) guarded(chunk);
        return;
    }
    allow_many_threads();
    tbb::task_arena arena(threads);
    arena.execute(
        [&] { tbb::parallel_for(std::size_t{0}, num_chunks, guarded, tbb::simple_partitioner{}); });
}

}  // namespace pointbake
