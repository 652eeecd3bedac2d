// Sizes of pages.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pointbake/atlas.h"

namespace pointbake {

inline constexpr int kPageUnit = 64;            ///< sides of pages are multiples of it
inline constexpr int kLargestPageSize = 16384;  ///< no GPU takes larger textures

/// Throws Error{kInvalidOption} unless page_size lies in [kPageUnit, kLargestPageSize].
void validate(const AtlasOptions& options);

/// The largest side a page may have.
int largest_side(const AtlasOptions& options);

/// The smallest pages that hold at least `texels`, each at least as large as `smallest` says; few
/// rather than exact.
std::vector<PageSize> pages_that_hold(std::int64_t texels, PageSize smallest,
                                      const AtlasOptions& options);

}  // namespace pointbake
