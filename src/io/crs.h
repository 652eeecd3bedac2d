// Coordinate reference systems as files name them: WKT of any kind, EPSG codes, GeoTIFF's keys.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pointbake/types.h"

namespace pointbake {

/// Takes over what a text says of the CRS: WKT 1 or 2, or "EPSG:2994". Returns a note if something
/// is wrong with it, which is no error; else nothing.
std::string add_crs(Frame& frame, std::string_view definition);

/// The same of GeoTIFF's keys and their texts, as records 34735 and 34737 of LAS hold them.
std::string add_crs(Frame& frame, std::span<const std::byte> keys, std::string_view texts);

/// What is wrong with such a frame for lengths: angles for x and y, heights in another unit. Empty
/// if nothing is.
std::string frame_warning(const Frame& frame);

}  // namespace pointbake
