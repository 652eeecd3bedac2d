// Sorting on several threads. The order must be total (end ties with an id): then the result is the
// same for any number.
#pragma once

#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <vector>

#include "core/parallel.h"

namespace pointbake {

template <class T, class Less = std::less<T>>
void parallel_sort(const Context& context, std::vector<T>& values, Less less = {}) {
    check_cancelled(context);
    if (num_threads(context) == 1) {
        std::sort(values.begin(), values.end(), less);
        return;
    }
    allow_many_threads();
    tbb::task_arena arena(num_threads(context));
    arena.execute([&] { tbb::parallel_sort(values.begin(), values.end(), less); });
}

}  // namespace pointbake
