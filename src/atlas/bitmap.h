// Packing of patches of any shape: charts.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/patch.h"

namespace pointbake {

/// Places the shapes, large ones first, each where it ends lowest in the first page that has room
/// for it, in any of eight poses; std::nullopt if one finds no room. Exact to the texel. Each place
/// is looked for in all columns of a row at once, by the bits of words.
std::optional<std::vector<Placement>> pack_bitmap(std::span<const PatchShape> shapes,
                                                  std::span<const PageSize> pages,
                                                  const Context& context);

}  // namespace pointbake
