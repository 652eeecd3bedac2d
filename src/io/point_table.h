// Columns of numbers under names, as points: which name means what. Shared by all formats whose
// rows are tables.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/number_type.h"
#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

struct TableColumn {
    std::string name;
    NumberType type = NumberType::kFloat64;  ///< as the file has it: tells the scale of colours
};

/// Consecutive rows, column by column.
struct TableBlock {
    std::size_t first_row = 0, num_rows = 0;
    std::vector<std::span<const double>> columns;  ///< those of wanted(), in its order
};

/// Points in the order of the file, and what was decided about them.
struct PointRows {
    PointCloud cloud;             ///< one entry per row; `rows` and `num_rows` are not filled
    std::vector<Vec3d> scanners;  ///< where they stood, as far as that is believed
    std::vector<std::string> notes;
};

class PointTable {
 public:
    /// `lacks` begins the complaint about a missing coordinate: "element 'vertex' has no scalar
    /// property". Throws Error{kInvalidInput} if there are no coordinates.
    PointTable(std::vector<TableColumn> columns, std::string path, std::string_view lacks);

    /// Which columns are to be handed over, in which order.
    const std::vector<std::size_t>& wanted() const { return wanted_; }

    /// Makes room; call it when the rows' bytes have been seen. Throws Error{kLimit} beyond
    /// 2^32 - 2 rows.
    void allocate(std::uint64_t num_rows);
    /// Where the type shows only in the values; the size of the colours must not change.
    void set_type(std::size_t column, NumberType type) { columns_[column].type = type; }
    /// Different rows may be stored on different threads.
    void store(const TableBlock& block);
    /// Once, at the end.
    PointRows finish(const Context& context);

 private:
    using Triple = std::array<std::size_t, 3>;  ///< places in wanted_

    std::optional<std::size_t> take_one(std::string_view name);
    bool has(std::string_view name) const;
    std::optional<Triple> take(const std::array<std::string_view, 3>& names);
    NumberType type_of(std::size_t column) const { return columns_[wanted_[column]].type; }

    void take_positions(std::string_view lacks);
    void take_colors();
    void take_directions();
    void take_channels();
    bool has_8bit_colors() const;
    void store_colors(const TableBlock& block);
    void finish_colors(const Context& context);
    void finish_radii();
    void finish_weights();

    std::vector<TableColumn> columns_;
    std::string path_;
    std::vector<bool> taken_;  ///< per column: has a role
    std::vector<std::size_t> wanted_;
    std::optional<Triple> position_, color_, harmonic_, normal_, sensor_, axis_u_, axis_v_;
    std::optional<std::size_t> radius_, area_;
    std::vector<std::size_t> channels_;  ///< place of each channel's column
    std::vector<Vec3f> raw_colors_;      ///< until their scale is known
    PointRows out_;
};

/// Names of columns are compared in lower case (ASCII).
std::string lower(std::string_view text);

}  // namespace pointbake
