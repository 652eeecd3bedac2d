// The middle value.
#pragma once

#include <algorithm>
#include <span>

namespace pointbake {

/// The upper one of two; 0 if there are none. Reorders the values. O(n).
template <class T>
T median_in_place(std::span<T> values) {
    if (values.empty()) return T{};
    const auto middle = values.begin() + std::ssize(values) / 2;
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace pointbake
