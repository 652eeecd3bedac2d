// Names as the usual programs write them; docs/stages/load.md has the list.
// Colours of Gaussian splats [Kerbl23] are degree 0 of the spherical harmonics.
#include "io/point_table.h"

#include <algorithm>
#include <cmath>

#include "core/message.h"
#include "core/parallel.h"
#include "io/splats.h"
#include "pointbake/error.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 8192;
// Float colours up to here are meant to be in [0, 1]: filters overshoot, but on the 8-bit scale a
// cloud that dark would be black.
constexpr double kUnitColorMax = 1.5;

/// Names of values that must never be averaged.
bool is_category_name(std::string_view name) {
    constexpr std::array<std::string_view, 13> kNames{
        "class",           "classification", "label",    "scan",   "category",
        "segment",         "flags",          "instance", "object", "object_id",
        "point_source_id", "user_data",      "row"};
    if (name.starts_with("scalar_")) name.remove_prefix(7);  // CloudCompare's prefix
    return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

std::uint16_t to_16bit(double unit) {
    if (!(unit > 0.0)) return 0;  // NaN, too
    return static_cast<std::uint16_t>(std::min(unit, 1.0) * 65535.0 + 0.5);
}

/// signed char is a usual slip for unsigned: negative values are the upper half.
std::uint16_t from_8bit(double value) {
    const double wrapped = value < 0.0 ? value + 256.0 : value;
    return to_16bit(wrapped / 255.0);
}

float radius_of(double value) {
    return std::isfinite(value) && value > 0.0 ? static_cast<float>(value) : 0.0F;
}

using Columns = std::array<std::size_t, 3>;

/// body(row, three values)
template <class Body>
void for_triples(const TableBlock& block, const std::optional<Columns>& columns, Body&& body) {
    if (!columns) return;
    const double* x = block.columns[(*columns)[0]].data();
    const double* y = block.columns[(*columns)[1]].data();
    const double* z = block.columns[(*columns)[2]].data();
    for (std::size_t i = 0; i < block.num_rows; ++i)
        body(block.first_row + i, Vec3d{x[i], y[i], z[i]});
}

/// body(row, value)
template <class Body>
void for_values(const TableBlock& block, std::size_t column, Body&& body) {
    const double* values = block.columns[column].data();
    for (std::size_t i = 0; i < block.num_rows; ++i) body(block.first_row + i, values[i]);
}

}  // namespace

std::string lower(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return out;
}

PointTable::PointTable(std::vector<TableColumn> columns, std::string path, std::string_view lacks)
    : columns_(std::move(columns)), path_(std::move(path)), taken_(columns_.size()) {
    take_positions(lacks);
    take_colors();
    normal_ = take({"nx", "ny", "nz"});
    if (!normal_) normal_ = take({"normal_x", "normal_y", "normal_z"});
    take_directions();
    for (std::string_view name : {"radius", "psz"})
        if (!radius_) radius_ = take_one(name);
    area_ = take_one("area");
    take_channels();
}

PointRows PointTable::finish(const Context& context) {
    finish_colors(context);
    finish_radii();
    finish_weights();
    return std::move(out_);
}

/// The column that the property of this name will be, if it is there and not taken yet.
std::optional<std::size_t> PointTable::take_one(std::string_view name) {
    for (std::size_t i = 0; i < taken_.size(); ++i) {
        if (taken_[i] || lower(columns_[i].name) != name) continue;
        taken_[i] = true;
        wanted_.push_back(i);
        return wanted_.size() - 1;
    }
    return std::nullopt;
}

bool PointTable::has(std::string_view name) const {
    for (std::size_t i = 0; i < taken_.size(); ++i)
        if (!taken_[i] && lower(columns_[i].name) == name) return true;
    return false;
}

/// All three or none.
std::optional<PointTable::Triple> PointTable::take(const std::array<std::string_view, 3>& names) {
    for (std::string_view name : names)
        if (!has(name)) return std::nullopt;
    return Triple{*take_one(names[0]), *take_one(names[1]), *take_one(names[2])};
}

void PointTable::take_positions(std::string_view lacks) {
    for (std::string_view name : {"x", "y", "z"})
        if (!has(name))
            fail(ErrorCode::kInvalidInput, "{}: {} '{}'; x, y and z are wanted", path_, lacks,
                 name);
    position_ = *take({"x", "y", "z"});
}

void PointTable::take_colors() {
    using Names = std::array<std::string_view, 3>;
    for (const Names& names :
         {Names{"red", "green", "blue"}, Names{"r", "g", "b"},
          Names{"diffuse_red", "diffuse_green", "diffuse_blue"}, Names{"rf", "gf", "bf"}})
        if (!color_) color_ = take(names);
    if (color_) return;
    harmonic_ = take({"f_dc_0", "f_dc_1", "f_dc_2"});
    if (harmonic_) out_.notes.emplace_back("colour from f_dc; f_rest is left out");
}

void PointTable::take_directions() {
    using Names = std::array<std::string_view, 3>;
    const std::array<std::pair<Names, Names>, 3> axes{
        {{{"u_x", "u_y", "u_z"}, {"v_x", "v_y", "v_z"}},
         {{"tx1", "ty1", "tz1"}, {"tx2", "ty2", "tz2"}},
         {{"ux", "uy", "uz"}, {"vx", "vy", "vz"}}}};
    for (const auto& [u, v] : axes) {
        if (axis_u_ || !has(u[0]) || !has(u[1]) || !has(u[2]) || !has(v[0]) || !has(v[1]) ||
            !has(v[2]))
            continue;
        axis_u_ = take(u);
        axis_v_ = take(v);
    }
    sensor_ = take({"sensor_x", "sensor_y", "sensor_z"});
    if (sensor_) return;
    sensor_ = take({"vx", "vy", "vz"});
    if (sensor_) out_.notes.emplace_back("vx, vy, vz read as the direction towards the sensor");
}

void PointTable::take_channels() {
    for (std::size_t i = 0; i < taken_.size(); ++i) {
        const std::string& name = columns_[i].name;
        if (taken_[i] || (harmonic_ && name.starts_with("f_rest_"))) continue;
        Channel channel;
        channel.name = name;
        if (is_category_name(lower(name))) channel.kind = ChannelKind::kCategory;
        out_.cloud.channels.push_back(std::move(channel));
        channels_.push_back(wanted_.size());
        wanted_.push_back(i);
    }
}

void PointTable::allocate(std::uint64_t num_rows) {
    if (num_rows >= kInvalidIndex)
        fail(ErrorCode::kLimit, "{}: {} points; at most {} are read", path_, num_rows,
             kInvalidIndex - 1);
    const auto n = static_cast<std::size_t>(num_rows);
    PointCloud& rows = out_.cloud;
    rows.positions.resize(n);
    if (color_ || harmonic_) rows.colors.resize(n);
    if (color_ && !has_8bit_colors()) raw_colors_.resize(n);
    if (normal_) rows.normals.resize(n);
    if (sensor_) rows.sensors.resize(n);
    if (axis_u_) rows.axes.resize(n);
    if (radius_) rows.radii.resize(n);
    if (area_) rows.areas.resize(n);
    for (Channel& channel : rows.channels) channel.data.resize(n);
}

bool PointTable::has_8bit_colors() const {
    return std::all_of(color_->begin(), color_->end(),
                       [&](std::size_t column) { return is_8bit(type_of(column)); });
}

void PointTable::store(const TableBlock& block) {
    PointCloud& rows = out_.cloud;
    for_triples(block, position_, [&](std::size_t row, Vec3d p) { rows.positions[row] = p; });
    store_colors(block);
    const auto direction = [](Vec3d v) {
        const Vec3d unit = normalized(v);
        return is_finite(unit) ? vec_cast<float>(unit) : Vec3f{};
    };
    for_triples(block, normal_,
                [&](std::size_t row, Vec3d n) { rows.normals[row] = direction(n); });
    for_triples(block, sensor_,
                [&](std::size_t row, Vec3d v) { rows.sensors[row] = direction(v); });
    for_triples(block, axis_u_,
                [&](std::size_t row, Vec3d u) { rows.axes[row].u = vec_cast<float>(u); });
    for_triples(block, axis_v_,
                [&](std::size_t row, Vec3d v) { rows.axes[row].v = vec_cast<float>(v); });
    if (radius_)
        for_values(block, *radius_,
                   [&](std::size_t row, double r) { rows.radii[row] = radius_of(r); });
    if (area_)
        for_values(block, *area_,
                   [&](std::size_t row, double a) { rows.areas[row] = radius_of(a); });
    for (std::size_t k = 0; k < channels_.size(); ++k) {
        std::vector<float>& data = rows.channels[k].data;
        for_values(block, channels_[k],
                   [&](std::size_t row, double v) { data[row] = static_cast<float>(v); });
    }
}

void PointTable::store_colors(const TableBlock& block) {
    std::vector<Rgb16>& colors = out_.cloud.colors;
    for_triples(block, harmonic_,
                [&](std::size_t row, Vec3d f) { colors[row] = color_of_harmonic(f); });
    if (raw_colors_.empty())
        for_triples(block, color_, [&](std::size_t row, Vec3d c) {
            colors[row] = {from_8bit(c.x), from_8bit(c.y), from_8bit(c.z)};
        });
    else
        for_triples(block, color_,
                    [&](std::size_t row, Vec3d c) { raw_colors_[row] = vec_cast<float>(c); });
}

/// The scale of colours wider than 8 bit shows in their largest value only.
void PointTable::finish_colors(const Context& context) {
    if (raw_colors_.empty()) return;
    const double max = parallel_reduce(
        context, raw_colors_.size(), kGrain, 0.0,
        [&](std::size_t begin, std::size_t end) {
            float m = 0.0F;
            for (std::size_t i = begin; i < end; ++i)
                for (std::size_t k = 0; k < 3; ++k)
                    if (std::isfinite(raw_colors_[i][k])) m = std::max(m, raw_colors_[i][k]);
            return static_cast<double>(m);
        },
        [](double a, double b) { return std::max(a, b); });
    const bool has_floats = std::any_of(color_->begin(), color_->end(), [&](std::size_t column) {
        return is_float(type_of(column));
    });
    double scale = 65535.0;
    if (has_floats && max <= kUnitColorMax)
        scale = 1.0;
    else if (max <= 255.0)
        scale = 255.0;
    else if (max > 65535.0)
        scale = max;
    out_.notes.push_back(
        fmt::format("colours are {} from 0 to {:.9g}", has_floats ? "floats" : "integers", scale));
    parallel_for(context, raw_colors_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3d c = vec_cast<double>(raw_colors_[i]) / scale;
            out_.cloud.colors[i] = {to_16bit(c.x), to_16bit(c.y), to_16bit(c.z)};
        }
    });
    raw_colors_ = {};
}

void PointTable::finish_radii() {
    const auto num_bad = std::count(out_.cloud.radii.begin(), out_.cloud.radii.end(), 0.0F);
    if (num_bad > 0)
        out_.notes.push_back(fmt::format("{} radii are not positive: taken as unknown", num_bad));
}

/// A channel `weight` is the points' weight if every value can be one.
void PointTable::finish_weights() {
    std::vector<Channel>& channels = out_.cloud.channels;
    const auto found = std::find_if(channels.begin(), channels.end(),
                                    [](const Channel& c) { return lower(c.name) == "weight"; });
    if (found == channels.end() || !std::all_of(found->data.begin(), found->data.end(),
                                                [](float w) { return w > 0.0F && w <= 1.0F; }))
        return;
    out_.cloud.weights = std::move(found->data);
    channels.erase(found);
}

}  // namespace pointbake
