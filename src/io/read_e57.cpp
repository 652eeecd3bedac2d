#include "io/read_e57.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/message.h"
#include "core/parallel.h"
#include "io/crs.h"
#include "io/e57_pages.h"
#include "io/e57_scans.h"
#include "io/e57_streams.h"
#include "io/finish_cloud.h"
#include "io/scanner.h"
#include "io/text_points.h"

namespace pointbake {
namespace {

using Bytes = std::span<const std::byte>;
using Names = std::array<const char*, 3>;

constexpr std::size_t kBlockRows = 8192;
constexpr Names kCartesian{"cartesianX", "cartesianY", "cartesianZ"};
constexpr Names kSpherical{"sphericalRange", "sphericalAzimuth", "sphericalElevation"};
constexpr Names kColors{"colorRed", "colorGreen", "colorBlue"};
constexpr Names kNormals{"nor:normalX", "nor:normalY", "nor:normalZ"};

/// Sine and cosine with the same bits on every machine, to about 1e-15.
struct SineCosine {
    double sine = 0.0, cosine = 1.0;

    explicit SineCosine(double angle) {
        constexpr double kHalfPi = 1.5707963267948966, kRest = 6.123233995736766e-17;
        if (!(std::abs(angle) < 1e6)) {
            sine = cosine = std::numeric_limits<double>::quiet_NaN();
            return;
        }
        const double turns = std::floor(angle / kHalfPi + 0.5);
        const double x = (angle - turns * kHalfPi) - turns * kRest, xx = x * x;
        // Taylor series up to |x| = pi / 4, from the last term on
        double s = 1.0, c = 1.0;
        for (double n = 16.0; n >= 2.0; n -= 2.0) {
            s = 1.0 - s * xx / (n * (n + 1.0));
            c = 1.0 - c * xx / (n * (n - 1.0));
        }
        s *= x;
        const int quadrant = static_cast<int>(turns - 4.0 * std::floor(turns / 4.0));
        sine = std::array{s, c, -s, -c}[static_cast<std::size_t>(quadrant)];
        cosine = std::array{c, -s, -c, s}[static_cast<std::size_t>(quadrant)];
    }
};

Vec3d rotated(const std::array<double, 4>& q, Vec3d p) {
    const Vec3d axis{q[1], q[2], q[3]};
    const Vec3d t = cross(axis, p) * 2.0;
    return p + t * q[0] + cross(axis, t);
}

bool has_all(const E57Scan& scan, const Names& names) {
    return std::ranges::all_of(names,
                               [&](const char* name) { return scan.find(name).has_value(); });
}

/// Fields that become no column under their own name.
bool is_special(std::string_view name) {
    for (const Names& names : {kCartesian, kSpherical, kColors, kNormals})
        if (std::ranges::find(names, name) != names.end()) return true;
    return name == "rowIndex" || name == "columnIndex" || name.ends_with("Invalid") ||
           name.ends_with("InvalidState");
}

/// What colours of a field are between: as the scan says, else the field.
std::array<double, 2> color_limits(const E57Scan& scan, std::size_t channel) {
    if (scan.color_limits[channel]) return *scan.color_limits[channel];
    const E57Field& field = scan.fields[*scan.find(kColors[channel])];
    if (field.limits && (*field.limits)[1] > (*field.limits)[0]) return *field.limits;
    return {0.0, field.kind == E57Field::Kind::kInteger ? 255.0 : 1.0};
}

class E57Reader {
 public:
    E57Reader(Bytes bytes, const std::string& name, const Context& context)
        : name_(name), context_(context), file_(open_e57(bytes, name, context)) {
        find_scans();
        find_columns();
    }

    PointRows read() {
        PointTable table(columns_, name_, "the scans have no");
        std::vector<E57Streams> streams;
        for (const E57Scan& scan : scans_) streams.emplace_back(file_, scan, name_);
        table.allocate(num_points_);
        is_empty_.assign(static_cast<std::size_t>(num_points_), 0);
        std::size_t first_row = 0;
        for (std::size_t i = 0; i < scans_.size(); ++i) {
            read_scan(scans_[i], streams[i], first_row, table);
            first_row += static_cast<std::size_t>(scans_[i].num_points);
        }
        PointRows points = table.finish(context_);
        drop_no_returns(points, is_empty_, "point", "marked as invalid, or 0 0 0");
        add_sensors(points);
        points.cloud.frame = frame_;
        points.notes.insert(points.notes.end(), notes_.begin(), notes_.end());
        return points;
    }

 private:
    void find_scans() {
        const std::string_view xml(
            reinterpret_cast<const char*>(file_.content.data()) + file_.xml_at,
            static_cast<std::size_t>(file_.xml_bytes));
        E57Scans found = read_e57_scans(xml, name_);
        frame_.up = UpAxis::kZ;
        if (std::string note = add_crs(frame_, found.coordinate_metadata); !note.empty())
            notes_.push_back(std::move(note));
        std::vector<E57Scan>& all = found.scans;
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (all[i].num_points == 0) continue;
            if (!has_all(all[i], kCartesian) && !has_all(all[i], kSpherical))
                fail(ErrorCode::kInvalidInput,
                     "{}: scan {} has no coordinates; cartesianX, cartesianY and cartesianZ are "
                     "wanted, or sphericalRange, sphericalAzimuth and sphericalElevation",
                     name_, i + 1);
            if (all[i].num_points >= kInvalidIndex - num_points_)
                fail(ErrorCode::kLimit, "{}: scan {} has {} points; at most {} are read at once",
                     name_, i + 1, all[i].num_points, kInvalidIndex - 1);
            num_points_ += all[i].num_points;
            scans_.push_back(std::move(all[i]));
        }
        if (scans_.empty()) fail(ErrorCode::kEmpty, "{}: the file holds 0 points", name_);
        std::string note = counted(all.size(), "scan");
        if (scans_.size() < all.size())
            note += fmt::format(", {} of them with points", scans_.size());
        notes_.push_back(std::move(note));
    }

    /// Those that all scans have.
    void find_columns() {
        columns_ = {{"x"}, {"y"}, {"z"}};
        const auto all_have = [&](const Names& names) {
            return std::ranges::all_of(scans_,
                                       [&](const E57Scan& scan) { return has_all(scan, names); });
        };
        has_colors_ = all_have(kColors);
        has_normals_ = all_have(kNormals);
        if (has_colors_)  // from 0 to 255, with fractions
            for (const char* name : {"red", "green", "blue"})
                columns_.push_back({name, NumberType::kUint8});
        if (has_normals_)
            for (const char* name : {"nx", "ny", "nz"}) columns_.push_back({name});
        num_special_ = columns_.size();
        std::string left_out;
        for (const E57Field& field : scans_[0].fields) {
            if (is_special(field.name) || !scans_[0].find(field.name)) continue;
            const bool is_common = std::ranges::all_of(
                scans_, [&](const E57Scan& scan) { return scan.find(field.name).has_value(); });
            if (is_common)
                columns_.push_back({field.name});
            else
                left_out += fmt::format("{}{}", left_out.empty() ? "" : ", ", field.name);
        }
        const bool some_colors =
            std::ranges::any_of(scans_, [](const E57Scan& scan) { return has_all(scan, kColors); });
        if (some_colors && !has_colors_) left_out += left_out.empty() ? "colours" : ", colours";
        if (!left_out.empty())
            notes_.push_back(fmt::format("not all scans have them, left out: {}", left_out));
    }

    void read_scan(const E57Scan& scan, const E57Streams& streams, std::size_t first_row,
                   PointTable& table) {
        const auto n = static_cast<std::size_t>(scan.num_points);
        parallel_for(context_, n, kBlockRows, [&](std::size_t begin, std::size_t end) {
            std::vector<std::vector<double>> columns(columns_.size());
            for (std::vector<double>& column : columns) column.resize(end - begin);
            load_positions(scan, streams, begin, first_row, columns);
            load_colors(scan, streams, begin, columns);
            load_normals(scan, streams, begin, columns);
            for (std::size_t k = num_special_; k < columns_.size(); ++k)
                streams.load(*scan.find(columns_[k].name), begin, columns[k]);
            TableBlock block{first_row + begin, end - begin, {}};
            for (const std::size_t column : table.wanted())
                block.columns.emplace_back(columns[column]);
            table.store(block);
        });
    }

    void load_positions(const E57Scan& scan, const E57Streams& streams, std::size_t begin,
                        std::size_t first_row, std::vector<std::vector<double>>& columns) {
        const bool is_cartesian = has_all(scan, kCartesian);
        const Names& names = is_cartesian ? kCartesian : kSpherical;
        for (std::size_t k = 0; k < 3; ++k) streams.load(*scan.find(names[k]), begin, columns[k]);
        std::vector<double> states(columns[0].size(), 0.0);
        const auto state =
            scan.find(is_cartesian ? "cartesianInvalidState" : "sphericalInvalidState");
        if (state) streams.load(*state, begin, states);
        for (std::size_t i = 0; i < states.size(); ++i) {
            Vec3d p{columns[0][i], columns[1][i], columns[2][i]};
            if (!is_cartesian) p = from_spherical(p);
            // Nothing can be seen where the scanner itself is: writers put zeros for no return.
            if (states[i] != 0.0 || p == Vec3d{}) is_empty_[first_row + begin + i] = 1;
            p = rotated(scan.rotation, p) + scan.translation;
            for (std::size_t k = 0; k < 3; ++k) columns[k][i] = p[k];
        }
    }

    static Vec3d from_spherical(Vec3d p) {
        if (p.x == 0.0) return {};
        const SineCosine azimuth(p.y), elevation(p.z);
        return Vec3d{elevation.cosine * azimuth.cosine, elevation.cosine * azimuth.sine,
                     elevation.sine} *
               p.x;
    }

    void load_colors(const E57Scan& scan, const E57Streams& streams, std::size_t begin,
                     std::vector<std::vector<double>>& columns) const {
        if (!has_colors_) return;
        for (std::size_t k = 0; k < 3; ++k) {
            std::vector<double>& column = columns[3 + k];
            streams.load(*scan.find(kColors[k]), begin, column);
            const auto [low, high] = color_limits(scan, k);
            if (low == 0.0 && high == 255.0) continue;
            for (double& v : column) v = std::clamp((v - low) / (high - low), 0.0, 1.0) * 255.0;
        }
    }

    void load_normals(const E57Scan& scan, const E57Streams& streams, std::size_t begin,
                      std::vector<std::vector<double>>& columns) const {
        if (!has_normals_) return;
        const std::size_t at = has_colors_ ? 6 : 3;
        for (std::size_t k = 0; k < 3; ++k)
            streams.load(*scan.find(kNormals[k]), begin, columns[at + k]);
        for (std::size_t i = 0; i < columns[at].size(); ++i) {
            const Vec3d n =
                rotated(scan.rotation, {columns[at][i], columns[at + 1][i], columns[at + 2][i]});
            for (std::size_t k = 0; k < 3; ++k) columns[at + k][i] = n[k];
        }
    }

    /// A scan's pose says where its scanner stood; without one, what has rows and columns was seen
    /// from the origin. Points that were moved before they were written lie far from it.
    void add_sensors(PointRows& points) const {
        std::size_t begin = 0;
        for (const E57Scan& scan : scans_) {
            const std::size_t end = begin + static_cast<std::size_t>(scan.num_points);
            const bool is_grid = scan.find("rowIndex") && scan.find("columnIndex");
            if (scan.has_pose || is_grid) add_scanner(points, begin, end, scan.translation);
            begin = end;
        }
    }

    const std::string& name_;
    const Context& context_;
    E57File file_;
    std::vector<E57Scan> scans_;  ///< those with points
    std::uint64_t num_points_ = 0;
    std::vector<TableColumn> columns_;
    std::size_t num_special_ = 0;  ///< columns that are not one field
    bool has_colors_ = false, has_normals_ = false;
    std::vector<std::uint8_t> is_empty_;  ///< per row
    Frame frame_;
    std::vector<std::string> notes_;
};

}  // namespace

bool is_e57(Bytes bytes) {
    return bytes.size() >= 8 && std::memcmp(bytes.data(), "ASTM-E57", 8) == 0;
}

LoadResult read_e57(Bytes bytes, const std::filesystem::path& path, const Context& context) {
    const std::string name = path.string();
    PointRows rows = E57Reader(bytes, name, context).read();
    report_progress(context, "load", 0.5);
    LoadResult result = finish_cloud(std::move(rows), "E57", name, context).result;
    report_progress(context, "load", 1.0);
    return result;
}

}  // namespace pointbake
