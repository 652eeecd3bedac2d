#include "io/scanner.h"

#include <algorithm>

#include "core/message.h"
#include "io/finish_cloud.h"
#include "io/text_points.h"

namespace pointbake {

void drop_no_returns(PointRows& points, std::span<const std::uint8_t> is_empty,
                     std::string_view noun, std::string_view why) {
    std::size_t num_empty = 0;
    for (std::size_t row = 0; row < is_empty.size(); ++row) {
        if (is_empty[row] == 0) continue;
        drop_row(points.cloud, row, DropReason::kNoReturn);
        ++num_empty;
    }
    if (num_empty == 0) return;
    std::sort(points.cloud.dropped.begin(), points.cloud.dropped.end(),
              [](const DroppedPoint& a, const DroppedPoint& b) { return a.row < b.row; });
    points.notes.push_back(
        fmt::format("{} without a return ({}): dropped", counted(num_empty, noun), why));
}

void add_scanner(PointRows& points, std::size_t begin, std::size_t end, Vec3d scanner) {
    Box box;
    for (std::size_t i = begin; i < end; ++i)
        if (is_finite(points.cloud.positions[i])) box.extend(points.cloud.positions[i]);
    if (box.is_empty()) return;
    const Vec3d nearest{std::clamp(scanner.x, box.low.x, box.high.x),
                        std::clamp(scanner.y, box.low.y, box.high.y),
                        std::clamp(scanner.z, box.low.z, box.high.z)};
    if (squared_length(nearest - scanner) <= squared_length(box.high - box.low))
        face_sensor(points, begin, end, scanner);
    else
        points.notes.push_back(
            fmt::format("scanner at {:.6g} {:.6g} {:.6g} ignored: far from its points", scanner.x,
                        scanner.y, scanner.z));
}

}  // namespace pointbake
