#include "io/finish_cloud.h"

#include <algorithm>
#include <limits>

#include "core/message.h"
#include "io/order.h"

namespace pointbake {
namespace {

/// All normals unknown is no normals at all.
void finish_normals(PointCloud& cloud, LoadReport& report) {
    const auto num_zero = std::count(cloud.normals.begin(), cloud.normals.end(), Vec3f{});
    report.num_zero_normals = static_cast<std::uint64_t>(num_zero);
    if (cloud.normals.empty() || report.num_zero_normals < cloud.normals.size()) return;
    cloud.normals.clear();
    cloud.given_normals.clear();
    report.notes.emplace_back("all normals are zero: ignored");
}

}  // namespace

FinishedCloud finish_cloud(PointRows rows, std::string format, const std::string& name,
                           const Context& context) {
    if (rows.cloud.positions.empty()) fail(ErrorCode::kEmpty, "{}: the file holds 0 points", name);
    const std::size_t num_left_out = rows.cloud.dropped.size();
    FinishedCloud finished;
    OrderedCloud ordered = order_cloud(std::move(rows.cloud), context);
    finished.point_of_row = std::move(ordered.point_of_row);
    PointCloud& cloud = finished.result.cloud = std::move(ordered.cloud);

    LoadReport& report = finished.result.report;
    report.format = std::move(format);
    report.scanners = std::move(rows.scanners);
    report.notes = std::move(rows.notes);
    report.num_rows = cloud.num_rows;
    report.num_kept = cloud.size();
    report.num_left_out = num_left_out;
    report.num_non_finite = cloud.dropped.size() - num_left_out;
    report.num_merged = cloud.merged.size();
    if (cloud.size() == 0 && num_left_out == 0)
        fail(ErrorCode::kEmpty, "{}: none of the {} points has finite coordinates", name,
             report.num_rows);
    if (cloud.size() == 0)
        fail(ErrorCode::kEmpty, "{}: none of the {} rows is a point: {}", name, report.num_rows,
             fmt::join(report.notes, "; "));
    finish_normals(cloud, report);
    return finished;
}

void drop_row(PointCloud& rows, std::size_t row, DropReason reason) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    rows.dropped.push_back({row, rows.positions[row], reason});
    rows.positions[row] = {kNone, kNone, kNone};
}

std::string counted(std::uint64_t count, std::string_view noun) {
    return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

}  // namespace pointbake
