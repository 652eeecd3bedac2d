// Morton order after [Morton66]. The grid hangs on the origin and its cells are powers of two, so
// that two clouds of about the same extent order common points alike; codes wrap around, so that
// 21 bits per axis are enough far from the origin, too.
#include "io/order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>

#include "core/color.h"
#include "core/parallel.h"
#include "core/parallel_sort.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 8192;
constexpr int kBitsPerAxis = 21;
constexpr double kCellsPerAxis = 2097152.0;  // 2^21
constexpr int kMinCellExponent = -1000;      // keeps 1 / cell finite

struct Entry {
    std::uint64_t code = 0;
    Index row = 0;
};

/// 21 bits, spread so that two zeros follow each.
std::uint64_t spread_bits(std::uint64_t x) {
    x = (x | (x << 32)) & 0x1f00000000ffffULL;
    x = (x | (x << 16)) & 0x1f0000ff0000ffULL;
    x = (x | (x << 8)) & 0x100f00f00f00f00fULL;
    x = (x | (x << 4)) & 0x10c30c30c30c30c3ULL;
    return (x | (x << 2)) & 0x1249249249249249ULL;
}

std::uint64_t cell_index(double coordinate, double cell) {
    // Divisions by powers of two are exact. Wrapping only permutes the curve's first octants.
    const double cells = std::floor(coordinate / cell);
    const double wrapped = cells - std::floor(cells / kCellsPerAxis) * kCellsPerAxis;
    if (std::isnan(wrapped)) return 0;  // an extent beyond all numbers has one cell
    return static_cast<std::uint64_t>(wrapped) & ((1U << kBitsPerAxis) - 1U);
}

/// The mean of values in any order: sorted first, so that their order does not matter. NaNs do not
/// count. Reorders and shortens `values`.
double mean_in_place(std::vector<double>& values) {
    std::erase_if(values, [](double v) { return std::isnan(v); });
    if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
    std::sort(values.begin(), values.end());
    double sum = 0.0;
    for (double v : values) sum += v;
    return sum / static_cast<double>(values.size());
}

/// Entries [begins[i], begins[i + 1]) are point i; the first is the lowest row.
struct Groups {
    std::vector<Entry> entries;
    std::vector<Index> begins;

    std::size_t size() const { return begins.size() - 1; }
    std::span<const Entry> operator[](std::size_t i) const {
        return std::span<const Entry>(entries).subspan(begins[i], begins[i + 1] - begins[i]);
    }
};

class Merger {
 public:
    Merger(const Groups& groups, const Context& context) : groups_(groups), context_(context) {}

    /// merge(rows of a point) for points of several rows, a copy for the others. Frees the input.
    template <class T, class Merge>
    void gather(std::vector<T>& values, Merge&& merge) const {
        if (values.empty()) return;
        std::vector<T> out(groups_.size());
        parallel_for(context_, out.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const std::span<const Entry> group = groups_[i];
                out[i] = group.size() == 1 ? values[group[0].row] : merge(values, group);
            }
        });
        values = std::move(out);
    }

    template <class T>
    void gather_lowest(std::vector<T>& values) const {
        gather(values, [](const std::vector<T>& all, std::span<const Entry> group) {
            return all[group[0].row];
        });
    }

    void gather_mean(std::vector<float>& values) const {
        gather(values, [](const std::vector<float>& all, std::span<const Entry> group) {
            return static_cast<float>(mean_of(group, [&](Index row) { return all[row]; }));
        });
    }

    void gather_direction(std::vector<Vec3f>& values) const {
        gather(values, [](const std::vector<Vec3f>& all, std::span<const Entry> group) {
            Vec3d mean;
            for (std::size_t k = 0; k < 3; ++k)
                mean[k] = mean_of(group, [&](Index row) { return all[row][k]; });
            return vec_cast<float>(normalized(mean));
        });
    }

    void gather_color(std::vector<Rgb16>& values) const {
        gather(values, [](const std::vector<Rgb16>& all, std::span<const Entry> group) {
            const Rgb16 first = all[group[0].row];
            if (std::all_of(group.begin(), group.end(),
                            [&](const Entry& e) { return all[e.row] == first; }))
                return first;
            const auto mean = [&](std::uint16_t Rgb16::* channel) {
                const double linear =
                    mean_of(group, [&](Index row) { return srgb_to_linear(all[row].*channel); });
                return static_cast<std::uint16_t>(linear_to_srgb_exact(linear) * 65535.0 + 0.5);
            };
            return Rgb16{mean(&Rgb16::r), mean(&Rgb16::g), mean(&Rgb16::b)};
        });
    }

    void gather_channel(Channel& channel) const {
        if (channel.num_components == 1) {
            if (channel.kind == ChannelKind::kCategory)
                gather_lowest(channel.data);
            else
                gather_mean(channel.data);
            return;
        }
        const std::size_t n = channel.num_components;
        std::vector<float> out(groups_.size() * n);
        parallel_for(context_, groups_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                for (std::size_t k = 0; k < n; ++k)
                    out[i * n + k] = static_cast<float>(
                        mean_of(groups_[i], [&](Index row) { return channel.data[row * n + k]; }));
        });
        channel.data = std::move(out);
    }

 private:
    template <class ValueOfRow>
    static double mean_of(std::span<const Entry> group, ValueOfRow&& value) {
        std::vector<double> values;
        values.reserve(group.size());
        for (const Entry& e : group) values.push_back(static_cast<double>(value(e.row)));
        return mean_in_place(values);
    }

    const Groups& groups_;
    const Context& context_;
};

/// Sorts the finite rows along the curve; rows of equal coordinates follow each other.
Groups group_rows(const std::vector<Vec3d>& positions, const Context& context) {
    Groups groups;
    Box box;
    groups.entries.reserve(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i) {
        if (!is_finite(positions[i])) continue;
        box.extend(positions[i]);
        groups.entries.push_back({0, static_cast<Index>(i)});
    }
    const double cell = morton_cell(box);
    std::vector<Entry>& entries = groups.entries;
    parallel_for(context, entries.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            entries[i].code = morton_code(positions[entries[i].row], cell);
    });
    parallel_sort(context, entries, [&](const Entry& a, const Entry& b) {
        if (a.code != b.code) return a.code < b.code;
        const Vec3d& p = positions[a.row];
        const Vec3d& q = positions[b.row];
        return std::tie(p.x, p.y, p.z, a.row) < std::tie(q.x, q.y, q.z, b.row);
    });
    for (std::size_t i = 0; i < entries.size(); ++i)
        if (i == 0 || !(positions[entries[i].row] == positions[entries[i - 1].row]))
            groups.begins.push_back(static_cast<Index>(i));
    groups.begins.push_back(static_cast<Index>(entries.size()));
    return groups;
}

/// Adds the rows that are no points and that no one has named yet.
void record_dropped(const std::vector<Index>& point_of_row, PointCloud& cloud) {
    std::vector<DroppedPoint> all;
    auto named = cloud.dropped.begin();
    for (std::size_t row = 0; row < point_of_row.size(); ++row) {
        if (point_of_row[row] != kInvalidIndex) continue;
        if (named != cloud.dropped.end() && named->row == row)
            all.push_back(*named++);
        else
            all.push_back({row, cloud.positions[row], DropReason::kNonFinite});
    }
    cloud.dropped = std::move(all);
}

/// What became of each row: fills rows, merged and dropped.
std::vector<Index> record_rows(const Groups& groups, PointCloud& cloud) {
    std::vector<Index> point_of_row(cloud.positions.size(), kInvalidIndex);
    cloud.num_rows = cloud.positions.size();
    cloud.rows.resize(groups.size());
    for (std::size_t i = 0; i < groups.size(); ++i) {
        const std::span<const Entry> group = groups[i];
        cloud.rows[i] = group[0].row;
        for (const Entry& e : group) {
            point_of_row[e.row] = static_cast<Index>(i);
            if (e.row != group[0].row) cloud.merged.emplace_back(e.row, group[0].row);
        }
    }
    std::sort(cloud.merged.begin(), cloud.merged.end());
    record_dropped(point_of_row, cloud);
    return point_of_row;
}

}  // namespace

double morton_cell(const Box& box) {
    if (box.is_empty()) return 1.0;
    // Halves, so that the difference of the largest doubles stays finite.
    const Vec3d half = box.high * 0.5 - box.low * 0.5;
    const double extent = std::max({half.x, half.y, half.z});
    // One cell to spare: the extent may begin and end inside of cells.
    const double wanted = extent / (kCellsPerAxis / 2.0 - 1.0);
    if (!(wanted > 0.0)) return 1.0;
    int exponent = 0;
    std::frexp(wanted, &exponent);  // wanted < 2^exponent
    return std::ldexp(1.0, std::max(exponent, kMinCellExponent));
}

std::uint64_t morton_code(Vec3d p, double cell) {
    return spread_bits(cell_index(p.x, cell)) << 2 | spread_bits(cell_index(p.y, cell)) << 1 |
           spread_bits(cell_index(p.z, cell));
}

OrderedCloud order_cloud(PointCloud rows, const Context& context) {
    OrderedCloud out;
    PointCloud& cloud = out.cloud = std::move(rows);
    for (Vec3d& p : cloud.positions) p += Vec3d{};  // -0 becomes 0
    const Groups groups = group_rows(cloud.positions, context);
    out.point_of_row = record_rows(groups, cloud);
    const Merger merger(groups, context);
    merger.gather_lowest(cloud.positions);
    merger.gather_color(cloud.colors);
    merger.gather_direction(cloud.normals);
    merger.gather_lowest(cloud.given_normals);
    merger.gather_mean(cloud.radii);
    merger.gather_mean(cloud.areas);
    merger.gather_lowest(cloud.axes);
    merger.gather_direction(cloud.sensors);
    merger.gather_mean(cloud.weights);
    for (Channel& channel : cloud.channels) merger.gather_channel(channel);
    return out;
}

}  // namespace pointbake
