// Several clouds as one.
#include <algorithm>

#include "core/message.h"
#include "io/order.h"
#include "pointbake/load.h"

namespace pointbake {
namespace {

using Parts = std::vector<LoadResult>;

/// Appends one array of every part, if every part has it.
template <class T>
void append_all(PointCloud& all, const Parts& parts, std::vector<T> PointCloud::* array,
                std::string_view name, std::vector<std::string>& notes) {
    const auto has = [&](const LoadResult& part) {
        return (part.cloud.*array).size() == part.cloud.size();
    };
    const auto num_with = std::ranges::count_if(parts, has);
    if (num_with == 0) return;
    if (num_with < static_cast<std::ptrdiff_t>(parts.size())) {
        notes.push_back(fmt::format("{} left out: {} of {} files have none", name,
                                    parts.size() - static_cast<std::size_t>(num_with),
                                    parts.size()));
        return;
    }
    for (const LoadResult& part : parts) {
        const std::vector<T>& from = part.cloud.*array;
        (all.*array).insert((all.*array).end(), from.begin(), from.end());
    }
}

const Channel* find_channel(const PointCloud& cloud, const Channel& like) {
    const auto found = std::ranges::find_if(cloud.channels, [&](const Channel& c) {
        return c.name == like.name && c.kind == like.kind &&
               c.num_components == like.num_components;
    });
    return found == cloud.channels.end() ? nullptr : &*found;
}

void append_channels(PointCloud& all, const Parts& parts, std::vector<std::string>& notes) {
    for (const Channel& first : parts[0].cloud.channels) {
        Channel merged = first;
        merged.data.clear();
        bool is_everywhere = true;
        for (const LoadResult& part : parts) {
            const Channel* const channel = find_channel(part.cloud, first);
            is_everywhere = is_everywhere && channel;
            if (channel)
                merged.data.insert(merged.data.end(), channel->data.begin(), channel->data.end());
        }
        if (is_everywhere)
            all.channels.push_back(std::move(merged));
        else
            notes.push_back(fmt::format("{} left out: not all files have it", first.name));
    }
}

PointCloud concatenated(const Parts& parts, std::vector<std::string>& notes) {
    PointCloud all;
    append_all(all, parts, &PointCloud::positions, "points", notes);
    append_all(all, parts, &PointCloud::colors, "colours", notes);
    append_all(all, parts, &PointCloud::normals, "normals", notes);
    append_all(all, parts, &PointCloud::given_normals, "signs of normals", notes);
    append_all(all, parts, &PointCloud::radii, "radii", notes);
    append_all(all, parts, &PointCloud::areas, "areas", notes);
    append_all(all, parts, &PointCloud::axes, "tangent axes", notes);
    append_all(all, parts, &PointCloud::sensors, "sensor directions", notes);
    append_all(all, parts, &PointCloud::weights, "weights", notes);
    append_channels(all, parts, notes);
    all.are_splats =
        std::ranges::all_of(parts, [](const LoadResult& part) { return part.cloud.are_splats; });
    return all;
}

/// Rows of the parts, counted on from part to part, for every entry of the concatenation.
std::vector<std::uint64_t> rows_of_entries(const Parts& parts) {
    std::vector<std::uint64_t> rows;
    std::uint64_t base = 0;
    for (const LoadResult& part : parts) {
        for (const std::uint64_t row : part.cloud.rows) rows.push_back(base + row);
        base += part.cloud.num_rows;
    }
    return rows;
}

/// From entries of the concatenation to rows of the files, which know more dropped and merged ones.
void restore_rows(PointCloud& cloud, const Parts& parts) {
    const std::vector<std::uint64_t> row_of = rows_of_entries(parts);
    for (std::uint64_t& row : cloud.rows) row = row_of[row];
    for (auto& [row, kept] : cloud.merged) {
        row = row_of[row];
        kept = row_of[kept];
    }
    std::ranges::sort(cloud.merged);
    const auto merged_between = cloud.merged;
    cloud.num_rows = 0;
    for (const LoadResult& part : parts) {
        for (DroppedPoint point : part.cloud.dropped) {
            point.row += cloud.num_rows;
            cloud.dropped.push_back(point);
        }
        for (const auto& [row, kept] : part.cloud.merged) {
            // What stood for it may itself have gone into a point of an earlier file.
            std::pair<std::uint64_t, std::uint64_t> entry = {row + cloud.num_rows,
                                                             kept + cloud.num_rows};
            const auto next =
                std::ranges::lower_bound(merged_between, entry.second, {}, &decltype(entry)::first);
            if (next != merged_between.end() && next->first == entry.second)
                entry.second = next->second;
            cloud.merged.push_back(entry);
        }
        cloud.num_rows += part.cloud.num_rows;
    }
    std::ranges::sort(cloud.merged);
}

/// Coordinates of several frames do not fit together; nothing is transformed.
Frame common_frame(const Parts& parts, const Context& context) {
    const Frame& frame = parts[0].cloud.frame;
    if (std::ranges::any_of(parts, [&](const LoadResult& p) { return p.cloud.frame != frame; }))
        log(context, LogLevel::kWarning,
            "the files differ in axes, units or coordinate system: all are taken for what the "
            "first is");
    return frame;
}

LoadReport summed_report(const Parts& parts, const PointCloud& cloud) {
    LoadReport sum;
    sum.format = fmt::format("{} files, the first {}", parts.size(), parts[0].report.format);
    for (const LoadResult& part : parts) {
        if (sum.guess.empty()) sum.guess = part.report.guess;
        sum.scanners.insert(sum.scanners.end(), part.report.scanners.begin(),
                            part.report.scanners.end());
        sum.num_non_finite += part.report.num_non_finite;
        sum.num_left_out += part.report.num_left_out;
        sum.num_zero_normals += part.report.num_zero_normals;
        sum.num_bad_faces += part.report.num_bad_faces;
        for (const std::string& note : part.report.notes)
            if (std::ranges::find(sum.notes, note) == sum.notes.end()) sum.notes.push_back(note);
    }
    sum.num_rows = cloud.num_rows;
    sum.num_kept = cloud.size();
    sum.num_merged = cloud.merged.size();
    return sum;
}

}  // namespace

LoadResult merge_clouds(Parts parts, const Context& context) {
    if (parts.size() == 1) return std::move(parts[0]);
    std::vector<std::string> notes;
    PointCloud all = concatenated(parts, notes);
    for (const std::string& note : notes)
        log(context, note.starts_with("colours") ? LogLevel::kWarning : LogLevel::kInfo, "{}",
            note);
    LoadResult result;
    all.frame = common_frame(parts, context);
    result.cloud = order_cloud(std::move(all), context).cloud;
    restore_rows(result.cloud, parts);
    result.report = summed_report(parts, result.cloud);
    if (std::ranges::any_of(parts, [](const LoadResult& p) { return p.mesh.has_value(); }))
        notes.emplace_back("faces left out: points of several files are taken alone");
    result.report.notes.insert(result.report.notes.end(), notes.begin(), notes.end());
    return result;
}

}  // namespace pointbake
