// What the XML of an E57 file says about its scans.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pointbake/vec.h"

namespace pointbake {

/// A number of each point, and how it is coded.
struct E57Field {
    enum class Kind { kInteger, kFloat, kDouble, kOther };  ///< scaled integers are integers
    std::string name;
    Kind kind = Kind::kDouble;
    std::int64_t least = 0;  ///< what integers are counted from
    unsigned num_bits = 64;  ///< 0: the same for all points
    double scale = 1.0, offset = 0.0;
    std::optional<std::array<double, 2>> limits;  ///< as the field itself says, after scaling
};

struct E57Scan {
    std::uint64_t points_at = 0;  ///< byte of the file
    std::uint64_t num_points = 0;
    std::vector<E57Field> fields;
    bool has_pose = false;
    std::array<double, 4> rotation{1.0, 0.0, 0.0, 0.0};  ///< w x y z, of length 1
    Vec3d translation;
    std::array<std::optional<std::array<double, 2>>, 3> color_limits;

    /// Nothing if there is no such field, or none that can be read.
    std::optional<std::size_t> find(std::string_view name) const;
};

/// Of the whole file.
struct E57Scans {
    std::vector<E57Scan> scans;
    std::string coordinate_metadata;  ///< the CRS, mostly as WKT; empty = not told
};

/// Throws Error{kInvalidInput} naming `name`.
E57Scans read_e57_scans(std::string_view xml, const std::string& name);

}  // namespace pointbake
