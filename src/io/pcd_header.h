// The header of a PCD file: which fields a point has, and how they are laid out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/number_type.h"
#include "pointbake/vec.h"

namespace pointbake {

enum class PcdData { kAscii, kBinary, kCompressed };
std::string_view to_string(PcdData data);  ///< as the header spells it

struct PcdField {
    std::string name;
    NumberType type = NumberType::kFloat32;
    std::size_t count = 1;   ///< values per point
    std::size_t offset = 0;  ///< bytes before it in a point

    std::size_t num_bytes() const { return size_of(type) * count; }
};

struct PcdHeader {
    std::vector<PcdField> fields;
    std::uint64_t width = 0, height = 1;
    std::uint64_t num_points = 0;    ///< as promised: believe it only when the bytes have been seen
    std::optional<Vec3d> viewpoint;  ///< unless it is left out or all zero
    PcdData data = PcdData::kAscii;
    std::size_t num_bytes = 0;  ///< where the data begin
    std::size_t row_bytes = 0;  ///< of a point, in binary files
    std::size_t row_values = 0;
    std::vector<std::string> notes;  ///< what was tolerated
};

/// `path` is for messages. Throws Error{kInvalidInput, kUnsupported} with the line.
PcdHeader read_pcd_header(std::string_view text, const std::string& path);

}  // namespace pointbake
