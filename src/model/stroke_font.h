// Letters as strokes: a plain, wide face made of straight lines and quarter ellipses.
#pragma once

#include <string_view>
#include <vector>

#include "pointbake/vec.h"

namespace pointbake {

/// A piece of stroke from a to b.
struct Stroke {
    Vec2d a, b;
};

/// A line of text in units of the capitals' height: baseline at y = 0, starting at x = 0. Holds
/// A-Z, a-z, 0-9 and common punctuation; other characters are blank.
struct TextStrokes {
    std::vector<Stroke> strokes;
    double width = 0.0;  ///< from the first stroke's left to the last one's right
};
TextStrokes text_strokes(std::string_view text);

}  // namespace pointbake
