// Point records of LAS files as columns. LAZ files hold the same records, compressed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/las_header.h"
#include "io/point_table.h"

namespace pointbake {

/// The numbers in a record of this header's format, coordinates first.
std::vector<LasField> las_fields(const LasHeader& header);

class LasPoints {
 public:
    LasPoints(const LasHeader& header, const std::string& name);

    /// Call it when the records' bytes have been seen.
    void allocate();
    /// Different records may be stored on different threads.
    void store(std::size_t first_row, std::size_t num_rows, const std::byte* records);
    /// Withheld points are dropped, and fields that are 0 in all records left out: every record
    /// has room for them, whether the scanner knew of them or not.
    PointRows finish(const Context& context);

 private:
    void drop_withheld(PointRows& points) const;

    const LasHeader& header_;
    std::vector<LasField> fields_;
    PointTable table_;
    std::vector<std::uint8_t> is_withheld_;  ///< per row
};

}  // namespace pointbake
