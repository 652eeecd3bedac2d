// How every reader of points ends: rows become an ordered cloud, and the report says what became of
// them.
#pragma once

#include <string>
#include <vector>

#include "io/point_table.h"
#include "pointbake/load.h"

namespace pointbake {

struct FinishedCloud {
    LoadResult result;
    std::vector<Index> point_of_row;  ///< as in OrderedCloud
};

/// `format` and `name` (of the file) are for the report and for messages. Throws Error{kEmpty} if
/// no row is a point.
FinishedCloud finish_cloud(PointRows rows, std::string format, const std::string& name,
                           const Context& context);

/// Drops a row before the cloud is finished, for another reason than its coordinates. Rows must
/// come in ascending order.
void drop_row(PointCloud& rows, std::size_t row, DropReason reason);

/// "1 row", "2 rows".
std::string counted(std::uint64_t count, std::string_view noun);

}  // namespace pointbake
