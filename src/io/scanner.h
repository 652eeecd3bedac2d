// What files of scans say of their scanner.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "io/point_table.h"
#include "pointbake/vec.h"

namespace pointbake {

/// Drops the rows that are marked: nothing came back there. `why` is for the note, `noun` is what
/// the file calls a row. Rows dropped before may be anywhere among them.
void drop_no_returns(PointRows& points, std::span<const std::uint8_t> is_empty,
                     std::string_view noun, std::string_view why);

/// The points of some rows were seen from there; a note instead if that is farther from them than
/// they extend, as where points were moved before they were written.
void add_scanner(PointRows& points, std::size_t begin, std::size_t end, Vec3d scanner);

}  // namespace pointbake
