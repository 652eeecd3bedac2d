// The only place that knows of threads. Chunks are cut by `grain`, never by the number of threads,
// and reduced in order: the result is the same bytes for 1 or N threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

#include "pointbake/context.h"

namespace pointbake {

/// Threads that a context asks for; 0 becomes the number of cores.
int num_threads(const Context& context);

/// Call before making a task arena of one's own.
void allow_many_threads();

/// Throws Error{kCancelled} if the context was told to stop.
void check_cancelled(const Context& context);

/// Calls body(chunk) for every chunk in [0, num_chunks), in any order, on context.threads threads.
/// Polls for cancellation once per chunk. The first exception is thrown to the caller.
void parallel_chunks(const Context& context, std::size_t num_chunks,
                     const std::function<void(std::size_t)>& body);

/// Calls body(begin, end) for consecutive ranges of at most `grain` indices that cover [0, count).
template <class Body>
void parallel_for(const Context& context, std::size_t count, std::size_t grain, Body&& body) {
    if (count == 0) return check_cancelled(context);
    parallel_chunks(context, (count + grain - 1) / grain, [&](std::size_t chunk) {
        body(chunk * grain, std::min(count, (chunk + 1) * grain));
    });
}

/// Combines map(begin, end) of consecutive ranges in their order: combine(combine(init, first),
/// second), ...
template <class T, class Map, class Combine>
T parallel_reduce(const Context& context, std::size_t count, std::size_t grain, T init, Map&& map,
                  Combine&& combine) {
    const std::size_t num_chunks = (count + grain - 1) / grain;
    std::vector<T> parts(num_chunks, init);
    parallel_for(context, count, grain, [&](std::size_t begin, std::size_t end) {
        parts[begin / grain] = map(begin, end);
    });
    for (T& part : parts) init = combine(std::move(init), std::move(part));
    return init;
}

}  // namespace pointbake
