// Clouds as binary little-endian PLY [Turk94]. PLY has no 64-bit integers: rows beyond 32 bits are
// doubles, exact up to 2^53.
#include <algorithm>
#include <limits>

#include "core/message.h"
#include "core/parallel_sort.h"
#include "pointbake/write.h"
#include "write/frame.h"
#include "write/placement.h"
#include "write/ply_output.h"

namespace pointbake {
namespace {

constexpr std::size_t kRowsPerPoll = std::size_t{1} << 16;

bool fit_32_bits(std::uint64_t largest_row) {
    return largest_row <= std::numeric_limits<std::uint32_t>::max();
}

void add_row_number(PlyRow& row, std::uint64_t number, bool as_uint) {
    if (as_uint)
        row.add(static_cast<std::uint32_t>(number));
    else
        row.add(static_cast<double>(number));
}

/// A channel's name as a PLY property can have it: no blanks.
std::string property_name(const Channel& channel, Index component) {
    std::string name = channel.name.empty() ? "channel" : channel.name;
    for (char& c : name)
        if (static_cast<unsigned char>(c) <= ' ') c = '_';
    return channel.num_components == 1 ? name : fmt::format("{}_{}", name, component);
}

void check_size(std::string_view what, std::size_t size, std::size_t expected) {
    if (size != 0 && size != expected)
        fail(ErrorCode::kInvalidInput, "the cloud has {} {} instead of {} or none", size, what,
             expected);
}

void check_cloud(const PointCloud& cloud) {
    const std::size_t n = cloud.size();
    check_size("colours", cloud.colors.size(), n);
    check_size("normals", cloud.normals.size(), n);
    check_size("radii", cloud.radii.size(), n);
    check_size("areas", cloud.areas.size(), n);
    check_size("axes", cloud.axes.size(), n);
    check_size("sensor directions", cloud.sensors.size(), n);
    check_size("weights", cloud.weights.size(), n);
    check_size("rows", cloud.rows.size(), n);
    check_size("measured positions", cloud.measured.size(), n);
    for (const Channel& channel : cloud.channels)
        check_size("values of '" + channel.name + "'", channel.data.size(),
                   n * channel.num_components);
}

/// How a cloud's rows are laid out.
struct Layout {
    bool as_double, as_16bit, as_uint;

    explicit Layout(const PointCloud& cloud)
        : as_double(!are_floats(cloud.positions)),
          as_16bit(!are_8bit(cloud.colors)),
          as_uint(cloud.rows.empty() ||
                  fit_32_bits(*std::max_element(cloud.rows.begin(), cloud.rows.end()))) {}
};

std::string cloud_header(const PointCloud& cloud, const Layout& layout) {
    PlyHeader header;
    if (const std::string text = frame_text(cloud.frame); !text.empty()) header.comment(text);
    for (const Channel& channel : cloud.channels)
        if (!channel.unit.empty())
            header.comment(fmt::format("unit {} {}", property_name(channel, 0), channel.unit));
    header.element("vertex", cloud.size());
    header.properties(layout.as_double ? "double" : "float", {"x", "y", "z"});
    if (!cloud.normals.empty()) header.properties("float", {"nx", "ny", "nz"});
    if (!cloud.colors.empty())
        header.properties(layout.as_16bit ? "ushort" : "uchar", {"red", "green", "blue"});
    if (!cloud.radii.empty()) header.property("float", "radius");
    if (!cloud.areas.empty()) header.property("float", "area");
    if (!cloud.axes.empty()) header.properties("float", {"ux", "uy", "uz", "vx", "vy", "vz"});
    if (!cloud.sensors.empty()) header.properties("float", {"sensor_x", "sensor_y", "sensor_z"});
    if (!cloud.weights.empty()) header.property("float", "weight");
    if (!cloud.rows.empty()) header.property(layout.as_uint ? "uint" : "double", "row");
    for (const Channel& channel : cloud.channels)
        for (Index k = 0; k < channel.num_components; ++k)
            header.property("float", property_name(channel, k));
    return header.text();
}

void add_point(PlyRow& row, const PointCloud& cloud, const Layout& layout, std::size_t i) {
    row.add_position(cloud.positions[i], layout.as_double);
    if (!cloud.normals.empty()) row.add(cloud.normals[i]);
    if (!cloud.colors.empty()) row.add_color(cloud.colors[i], layout.as_16bit);
    if (!cloud.radii.empty()) row.add(cloud.radii[i]);
    if (!cloud.areas.empty()) row.add(cloud.areas[i]);
    if (!cloud.axes.empty()) {
        row.add(cloud.axes[i].u);
        row.add(cloud.axes[i].v);
    }
    if (!cloud.sensors.empty()) row.add(cloud.sensors[i]);
    if (!cloud.weights.empty()) row.add(cloud.weights[i]);
    if (!cloud.rows.empty()) add_row_number(row, cloud.rows[i], layout.as_uint);
    for (const Channel& channel : cloud.channels)
        for (Index k = 0; k < channel.num_components; ++k)
            row.add(channel.data[i * channel.num_components + k]);
}

/// What is said of an input row.
struct RowEntry {
    std::uint64_t row = 0;
    Vec3d position;
    DropReason reason = DropReason::kKept;
    bool is_kept = true;
    friend bool operator<(const RowEntry& a, const RowEntry& b) { return a.row < b.row; }
};

/// Points and dropped rows, by row, then merged ones put in among them.
std::vector<RowEntry> row_entries(const PointCloud& cloud,
                                  std::span<const std::uint8_t> off_surface,
                                  const Context& context) {
    std::vector<RowEntry> entries;
    entries.reserve(cloud.size() + cloud.dropped.size() + cloud.merged.size());
    const std::vector<Vec3d>& read = cloud.measured.empty() ? cloud.positions : cloud.measured;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const bool is_off = !off_surface.empty() && off_surface[i] != 0;
        entries.push_back({cloud.rows.empty() ? i : cloud.rows[i], read[i],
                           is_off ? DropReason::kOffSurface : DropReason::kKept, !is_off});
    }
    for (const DroppedPoint& d : cloud.dropped)
        entries.push_back({d.row, d.position, d.reason, false});
    parallel_sort(context, entries);

    const std::size_t num_sorted = entries.size();
    for (const auto& [row, stand_in] : cloud.merged) {
        const auto end = entries.begin() + static_cast<std::ptrdiff_t>(num_sorted);
        const auto at =
            std::lower_bound(entries.begin(), end, stand_in,
                             [](const RowEntry& e, std::uint64_t r) { return e.row < r; });
        if (at == end || at->row != stand_in)
            fail(ErrorCode::kInvalidInput, "row {} is merged into row {}, which is no point", row,
                 stand_in);
        RowEntry entry = *at;
        entry.row = row;
        if (entry.is_kept) entry.reason = DropReason::kMerged;
        entries.push_back(entry);
    }
    if (!cloud.merged.empty()) parallel_sort(context, entries);
    return entries;
}

}  // namespace

WriteReport write_cloud(const PointCloud& cloud, const std::filesystem::path& path,
                        const Context& context) {
    check_cloud(cloud);
    const Layout layout(cloud);
    FileSet files;
    AtomicFile& file = files.add(path);
    file.write(cloud_header(cloud, layout));
    PlyRow row;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        if (i % kRowsPerPoll == 0) check_cancelled(context);
        add_point(row, cloud, layout, i);
        row.write_to(file);
    }
    WriteReport report;
    report.num_vertices = cloud.size();
    report.frame = cloud.frame;
    commit_with_prj(files, path, report, context);
    return report;
}

void write_points(const PointCloud& cloud, std::span<const std::uint8_t> off_surface,
                  const std::filesystem::path& path, const Context& context) {
    check_cloud(cloud);
    check_size("marks", off_surface.size(), cloud.size());
    AtomicFile file(path);
    const std::vector<RowEntry> entries = row_entries(cloud, off_surface, context);
    const bool as_double = std::any_of(entries.begin(), entries.end(), [](const RowEntry& e) {
        return !are_floats(std::span(&e.position, 1));
    });
    const bool as_uint = entries.empty() || fit_32_bits(entries.back().row);

    PlyHeader header;
    for (int i = 0; i < kNumDropReasons; ++i)
        header.comment(fmt::format("reason {} {}", i, to_string(static_cast<DropReason>(i))));
    header.element("vertex", entries.size());
    header.properties(as_double ? "double" : "float", {"x", "y", "z"});
    header.property(as_uint ? "uint" : "double", "row");
    header.properties("uchar", {"kept", "reason"});
    file.write(header.text());

    PlyRow row;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        if (i % kRowsPerPoll == 0) check_cancelled(context);
        const RowEntry& e = entries[i];
        row.add_position(e.position, as_double);
        add_row_number(row, e.row, as_uint);
        row.add(static_cast<std::uint8_t>(e.is_kept));
        row.add(static_cast<std::uint8_t>(e.reason));
        row.write_to(file);
    }
    file.commit();
}

}  // namespace pointbake
