// What stands in front of the points of a LAS or LAZ file, versions 1.0 to 1.5.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/number_type.h"
#include "pointbake/types.h"

namespace pointbake {

/// A number in every record, whose meaning is (bits >> shift & mask) * scale + offset.
struct LasField {
    std::string name;
    NumberType type = NumberType::kUint8;
    std::size_t at = 0;  ///< byte in the record
    unsigned shift = 0;
    unsigned mask = 0;  ///< 0: all bits
    double scale = 1.0, offset = 0.0;
    std::optional<double> no_data = {};  ///< the raw value that stands for none
};

struct LasHeader {
    int minor_version = 0;
    int point_format = 0;  ///< 0 to 10
    bool is_compressed = false;
    std::size_t record_bytes = 0;
    std::size_t points_at = 0;  ///< byte of the first record, not beyond the end of the file
    std::uint64_t num_points = 0;
    Vec3d scale, offset;
    std::vector<LasField> extra;         ///< as the record of extra bytes names them
    std::span<const std::byte> laz_vlr;  ///< how the points are compressed
    Frame frame;
    std::vector<std::string> notes;
};

/// Bytes of a record of point format 0 to 10, without extra bytes.
std::size_t las_record_bytes(int point_format);

/// Whether classes have eight bits and flags a byte of their own.
inline bool is_new_las_format(int point_format) { return point_format >= 6; }

/// Throws Error{kInvalidInput, kUnsupported, kEmpty} naming `name` and the byte.
LasHeader read_las_header(std::span<const std::byte> bytes, const std::string& name);

}  // namespace pointbake
