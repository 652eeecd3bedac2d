#include "io/text_points.h"

#include <algorithm>

#include "core/message.h"
#include "io/finish_cloud.h"

namespace pointbake {

std::string TextSource::place(std::string_view part) const {
    return fmt::format(
        "{}:{}", name,
        line_of_byte(text, static_cast<std::size_t>(part.data() - text.data()), line_end));
}

void BadRows::add(const TextBlock& block, std::size_t base) {
    if (block.bad.empty()) return;
    const std::scoped_lock lock(mutex_);
    for (const BadTextRow& bad : block.bad)
        entries_.push_back({base + bad.row, bad.line, bad.problem});
}

void BadRows::drop_from(PointRows& rows, const TextSource& source, std::size_t num_columns) {
    if (entries_.empty()) return;
    std::sort(entries_.begin(), entries_.end(),
              [](const Entry& a, const Entry& b) { return a.row < b.row; });
    const std::string place = source.place(entries_[0].line);
    if (entries_.size() > rows.cloud.positions.size() / 2)
        fail(ErrorCode::kInvalidInput,
             "{}: {}; {} of {} rows are not {} numbers, with blanks, commas or semicolons between "
             "them",
             place, entries_[0].problem, entries_.size(), rows.cloud.positions.size(), num_columns);
    for (const Entry& entry : entries_) drop_row(rows.cloud, entry.row, DropReason::kUnreadable);
    rows.notes.push_back(fmt::format("{} not of {} numbers: dropped (the first at {}: {})",
                                     counted(entries_.size(), "row"), num_columns, place,
                                     entries_[0].problem));
}

void face_sensor(PointRows& rows, std::size_t begin, std::size_t end, Vec3d sensor) {
    PointCloud& cloud = rows.cloud;
    cloud.sensors.resize(cloud.positions.size());
    for (std::size_t i = begin; i < end; ++i) {
        const Vec3d unit = normalized(sensor - cloud.positions[i]);
        cloud.sensors[i] = is_finite(unit) ? vec_cast<float>(unit) : Vec3f{};
    }
    rows.scanners.push_back(sensor);
}

}  // namespace pointbake
