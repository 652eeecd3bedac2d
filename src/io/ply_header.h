// The header of a PLY file: what elements there are, and how their rows are laid out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/number_type.h"

namespace pointbake {

enum class PlyFormat { kAscii, kLittleEndian, kBigEndian };
std::string_view to_string(PlyFormat format);  ///< as the header spells it

struct PlyProperty {
    std::string name;
    NumberType type = NumberType::kFloat32;
    std::optional<NumberType> count_type;  ///< set for lists

    bool is_list() const { return count_type.has_value(); }
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;  ///< as promised: believe it only when the bytes have been seen
    std::vector<PlyProperty> properties;

    bool has_lists() const;
    /// Bytes of a binary row without the lists' values; at least this much per row.
    std::size_t min_row_bytes() const;
    /// Position of the first property of that name.
    std::optional<std::size_t> find(std::string_view property) const;
};

struct PlyHeader {
    PlyFormat format = PlyFormat::kAscii;
    std::vector<PlyElement> elements;
    std::vector<std::string> comments;
    std::vector<std::string> notes;  ///< what was tolerated
    std::size_t num_bytes = 0;       ///< where the data begin
    std::size_t num_lines = 0;
    char line_end = '\n';  ///< '\r' in files whose lines end in CR alone

    /// Position of the first element of that name.
    std::optional<std::size_t> find(std::string_view element) const;
};

/// Whether the bytes begin like a PLY file (blank space may precede the magic word).
bool is_ply(std::span<const std::byte> bytes);

/// Lines may end in LF, CR LF or CR. `path` is for messages. Throws Error{kInvalidInput,
/// kUnsupported} with the line.
PlyHeader read_ply_header(std::span<const std::byte> bytes, const std::string& path);

}  // namespace pointbake
