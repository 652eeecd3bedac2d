#include "io/las_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/message.h"
#include "io/finish_cloud.h"

namespace pointbake {
namespace {

constexpr double kScanAngleStep = 0.006;  // degrees, in point formats 6 to 10

std::vector<TableColumn> columns_of(const std::vector<LasField>& fields) {
    std::vector<TableColumn> columns;
    for (const LasField& f : fields) columns.push_back({f.name, f.type});
    return columns;
}

void load_field(const LasField& field, const std::byte* records, std::size_t stride,
                std::span<double> to) {
    load_column(field.type, records + field.at, stride, false, to);
    if (field.mask != 0)
        for (double& v : to)
            v = static_cast<double>(static_cast<unsigned>(v) >> field.shift & field.mask);
    if (field.no_data)
        for (double& v : to)
            if (v == *field.no_data) v = std::numeric_limits<double>::quiet_NaN();
    if (field.scale != 1.0 || field.offset != 0.0)
        for (double& v : to) v = v * field.scale + field.offset;
}

void leave_out_zeros(PointRows& points) {
    std::string names;
    const auto note = [&](std::string_view name) {
        names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
    };
    PointCloud& cloud = points.cloud;
    const auto is_black = [](Rgb16 c) { return c == Rgb16{}; };
    if (!cloud.colors.empty() && std::ranges::all_of(cloud.colors, is_black)) {
        cloud.colors.clear();
        std::erase_if(points.notes, [](const std::string& n) { return n.starts_with("colours"); });
        note("colours");
    }
    std::erase_if(cloud.channels, [&](const Channel& channel) {
        const bool is_zero =
            std::ranges::all_of(channel.data, [](float v) { return v == 0.0F || std::isnan(v); });
        if (is_zero) note(channel.name);
        return is_zero;
    });
    if (!names.empty())
        points.notes.push_back(fmt::format("0 in all records, left out: {}", names));
}

}  // namespace

std::vector<LasField> las_fields(const LasHeader& header) {
    using enum NumberType;
    std::vector<LasField> fields;
    const auto add = [&](const char* name, NumberType type, std::size_t at) -> LasField& {
        return fields.emplace_back(LasField{name, type, at});
    };
    for (std::size_t k = 0; k < 3; ++k) {
        LasField& field = add(std::array{"x", "y", "z"}[k], kInt32, 4 * k);
        field.scale = header.scale[k];
        field.offset = header.offset[k];
    }
    const int format = header.point_format;
    const bool is_new = is_new_las_format(format);
    const auto add_bits = [&](const char* name, std::size_t at, unsigned shift, unsigned mask) {
        LasField& field = add(name, kUint8, at);
        field.shift = shift;
        field.mask = mask;
    };
    add("intensity", kUint16, 12);
    add_bits("return_number", 14, 0, is_new ? 15 : 7);
    add_bits("number_of_returns", 14, is_new ? 4 : 3, is_new ? 15 : 7);
    if (is_new)
        add("classification", kUint8, 16);
    else
        add_bits("classification", 15, 0, 31);
    if (is_new)
        add("scan_angle", kInt16, 18).scale = kScanAngleStep;
    else
        add("scan_angle", kInt8, 16);
    add("user_data", kUint8, 17);
    add("point_source_id", kUint16, is_new ? 20 : 18);

    std::size_t at = is_new ? 22 : 20;
    if (format != 0 && format != 2) {
        add("gps_time", kFloat64, at);
        at += 8;
    }
    const bool has_color =
        format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10;
    if (has_color)
        for (const char* name : {"red", "green", "blue"}) {
            add(name, kUint16, at);
            at += 2;
        }
    if (format == 8 || format == 10) add("nir", kUint16, at);
    fields.insert(fields.end(), header.extra.begin(), header.extra.end());
    return fields;
}

LasPoints::LasPoints(const LasHeader& header, const std::string& name)
    : header_(header),
      fields_(las_fields(header)),
      table_(columns_of(fields_), name, "the records have no") {}

void LasPoints::allocate() {
    table_.allocate(header_.num_points);
    is_withheld_.resize(static_cast<std::size_t>(header_.num_points));
}

void LasPoints::store(std::size_t first_row, std::size_t num_rows, const std::byte* records) {
    const std::size_t stride = header_.record_bytes;
    // Each column goes through the records once: few enough to stay in the cache meanwhile.
    const std::size_t most_rows = std::min<std::size_t>(num_rows, 512);
    std::vector<std::vector<double>> values(table_.wanted().size(), std::vector<double>(most_rows));
    for (std::size_t begin = 0; begin < num_rows; begin += most_rows) {
        TableBlock block{first_row + begin, std::min(most_rows, num_rows - begin), {}};
        for (std::size_t k = 0; k < values.size(); ++k) {
            const std::span<double> column(values[k].data(), block.num_rows);
            load_field(fields_[table_.wanted()[k]], records + begin * stride, stride, column);
            block.columns.emplace_back(column);
        }
        table_.store(block);
    }

    const std::byte flag{is_new_las_format(header_.point_format) ? std::uint8_t{0x04}
                                                                 : std::uint8_t{0x80}};
    constexpr std::size_t kFlagsAt = 15;
    for (std::size_t i = 0; i < num_rows; ++i)
        is_withheld_[first_row + i] = (records[i * stride + kFlagsAt] & flag) != std::byte{};
}

PointRows LasPoints::finish(const Context& context) {
    PointRows points = table_.finish(context);
    points.notes.insert(points.notes.begin(), header_.notes.begin(), header_.notes.end());
    leave_out_zeros(points);
    drop_withheld(points);
    return points;
}

void LasPoints::drop_withheld(PointRows& points) const {
    std::size_t num_withheld = 0;
    for (std::size_t row = 0; row < is_withheld_.size(); ++row) {
        if (is_withheld_[row] == 0) continue;
        drop_row(points.cloud, row, DropReason::kWithheld);
        ++num_withheld;
    }
    if (num_withheld > 0)
        points.notes.push_back(
            fmt::format("{} marked as withheld: dropped", counted(num_withheld, "point")));
}

}  // namespace pointbake
