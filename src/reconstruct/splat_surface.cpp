#include <algorithm>
#include <cmath>
#include <span>

#include "core/kernel.h"
#include "core/median.h"
#include "core/message.h"
#include "core/parallel.h"
#include "core/union_find.h"
#include "pointbake/error.h"
#include "pointbake/splats.h"
#include "reconstruct/contour.h"
#include "reconstruct/splat_grid.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 1024;
constexpr double kStepOverSigma = 3.0;  // of the splats' median second standard deviation
constexpr double kLeastPiece = 1e-3;    // of the largest one's triangles
// A look along the normal begins and ends so many steps before and behind the surface.
constexpr double kBefore = 3.0, kBehind = 6.0;
constexpr int kSmoothings = 10;
constexpr double kSunk = 0.7;      // of the depth
constexpr double kMostSunk = 1.5;  // steps
constexpr float kLeastSeen = 1.0F / 255.0F, kDark = 0.01F;
constexpr float kCut2 = kSplatCut * kSplatCut;

/// Those with any opacity.
struct Splats {
    std::vector<Splat> items;
    std::vector<Index> points;  ///< of the cloud
};

Splats splats_of(const PointCloud& cloud) {
    Splats out;
    for (Index i = 0; i < cloud.size(); ++i) {
        const Splat splat = splat_of(cloud, i);
        if (splat.opacity > 0.0F) out.items.push_back(splat), out.points.push_back(i);
    }
    if (out.items.empty())
        fail(ErrorCode::kDegenerate, "none of the {} splats has any opacity", cloud.size());
    return out;
}

double median_size(const std::vector<Splat>& splats) {
    std::vector<float> sizes;
    for (const Splat& s : splats) sizes.push_back(std::min(s.sigmas[0], s.sigmas[1]));
    return static_cast<double>(median_in_place(std::span(sizes)));
}

/// The grid's tetrahedra where it changes its sign, contoured.
class Contouring {
 public:
    Contouring(const SplatGrid& field, const Context& context)
        : field_(field), context_(context), grid_(make_grid(field, units_)) {}

    Mesh run() {
        std::size_t count = 0;
        for (const SplatGrid::Point& cube : field_.mixed_cubes(context_)) {
            if (++count % kGrain == 0) check_cancelled(context_);
            grid_.split({cube[0] * units_ + units_ / 2, cube[1] * units_ + units_ / 2,
                         cube[2] * units_ + units_ / 2});
        }
        values_.resize(grid_.num_nodes());
        parallel_for(context_, values_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                values_[i] = value_at(grid_.point(static_cast<Index>(i)));
        });
        const std::vector<std::uint8_t> may_snap(values_.size(), 1);
        Contour contour = find_contour(grid_, values_, may_snap, context_);
        Mesh mesh;
        for (const ContourVertex& v : contour.vertices) mesh.positions.push_back(place_of(v));
        mesh.triangles = std::move(contour.triangles);
        return mesh;
    }

 private:
    static SimplexGrid make_grid(const SplatGrid& field, std::int32_t& units) {
        constexpr int kMostCubes = 7;
        const SplatGrid::Point size = field.size();
        int level = 0;  // 2^level steps a cube
        const auto cubes = [&](std::size_t k) { return static_cast<int>((size[k] >> level) + 1); };
        while (std::max({cubes(0), cubes(1), cubes(2)}) > kMostCubes) ++level;
        units = SimplexGrid::kCubeUnits >> level;
        return SimplexGrid(field.place({0.0, 0.0, 0.0}), std::ldexp(field.step(), level),
                           {cubes(0), cubes(1), cubes(2)});
    }

    /// At a point of the lattice its own value, in a cube's middle the mean of its corners'.
    float value_at(const SimplexGrid::Point& p) const {
        SplatGrid::Point low{};
        bool is_middle = false;
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = p[k] / units_;
            is_middle |= p[k] % units_ != 0;
        }
        if (!is_middle) return field_.value(low);
        float sum = 0.0F;
        for (std::int32_t corner = 0; corner < 8; ++corner)
            sum += field_.value(
                {low[0] + (corner & 1), low[1] + (corner >> 1 & 1), low[2] + (corner >> 2)});
        return sum / 8.0F;
    }

    Vec3d gradient_at(const SimplexGrid::Point& p) const {
        Vec3d out;
        for (std::size_t k = 0; k < 3; ++k) {
            SimplexGrid::Point before = p, after = p;
            before[k] -= units_;
            after[k] += units_;
            out[k] =
                static_cast<double>(value_at(after) - value_at(before)) / (2.0 * field_.step());
        }
        return out;
    }

    Vec3d place_of(const ContourVertex& v) const {
        const Vec3d outside = grid_.place(v.outside);
        const auto at_outside = static_cast<double>(values_[v.outside]);
        if (!v.is_snapped()) {
            const auto at_inside = static_cast<double>(values_[v.inside]);
            return outside +
                   (grid_.place(v.inside) - outside) * (at_outside / (at_outside - at_inside));
        }
        constexpr double kMostMoved = 0.3;  // steps
        const Vec3d gradient = gradient_at(grid_.point(v.outside));
        const double slope = length(gradient);
        if (slope == 0.0) return outside;
        const double most = kMostMoved * field_.step();
        return outside - gradient / slope * std::clamp(at_outside / slope, -most, most);
    }

    const SplatGrid& field_;
    const Context& context_;
    std::int32_t units_ = 0;  ///< of the simplex grid, in a step
    SimplexGrid grid_;
    std::vector<float> values_;
};

/// Without pieces of few triangles beside the largest.
Mesh without_crumbs(const Mesh& mesh) {
    UnionFind pieces(mesh.positions.size());
    for (const Triangle& t : mesh.triangles) pieces.unite(t[0], t[1]), pieces.unite(t[0], t[2]);
    std::vector<std::size_t> sizes(mesh.positions.size());
    for (const Triangle& t : mesh.triangles) ++sizes[pieces.find(t[0])];
    const auto least =
        kLeastPiece * static_cast<double>(*std::max_element(sizes.begin(), sizes.end()));
    Mesh out;
    std::vector<Index> rank(mesh.positions.size(), kInvalidIndex);
    for (Index v = 0; v < rank.size(); ++v) {
        if (static_cast<double>(sizes[pieces.find(v)]) < least) continue;
        rank[v] = static_cast<Index>(out.positions.size());
        out.positions.push_back(mesh.positions[v]);
    }
    for (const Triangle& t : mesh.triangles)
        if (rank[t[0]] != kInvalidIndex)
            out.triangles.push_back({rank[t[0]], rank[t[1]], rank[t[2]]});
    return out;
}

/// Looks at the splats along normals.
class Viewer {
 public:
    Viewer(const PointCloud& cloud, const Splats& splats, const SplatGrid& grid)
        : cloud_(cloud), splats_(splats), grid_(grid) {}

    struct View {
        Rgb16 color{};
        Index point = kInvalidIndex;  ///< that shows most; none = nothing is seen
        float depth = 0.0F;           ///< mean of what shows, behind the place
    };
    View from_outside(Vec3d place, Vec3f normal) {
        find_hits(place, normal, 0.0F);
        // The grid has thickened what is thinner than its steps.
        if (hits_.empty())
            find_hits(place, normal, static_cast<float>(SplatGrid::kThinnest * grid_.step()));
        std::sort(hits_.begin(), hits_.end());
        Vec3f sum;
        float passed = 1.0F, most = 0.0F, depth = 0.0F;
        View view;
        for (const Hit& hit : hits_) {
            const float shown = passed * hit.opacity;
            if (!cloud_.colors.empty()) {
                const Rgb16 c = cloud_.colors[splats_.points[hit.splat]];
                sum += Vec3f{static_cast<float>(c.r), static_cast<float>(c.g),
                             static_cast<float>(c.b)} *
                       shown;
            }
            depth += hit.depth * shown;
            if (shown > most) most = shown, view.point = splats_.points[hit.splat];
            passed *= 1.0F - hit.opacity;
            if (passed < kDark) break;
        }
        if (passed < 1.0F) {
            view.depth = depth / (1.0F - passed);
            const Vec3f mean = sum / (1.0F - passed);
            const auto rounded = [](float x) {
                return static_cast<std::uint16_t>(std::min(x + 0.5F, 65535.0F));
            };
            view.color = {rounded(mean.x), rounded(mean.y), rounded(mean.z)};
        }
        return view;
    }

 private:
    struct Hit {
        float depth;  ///< along the look, from the surface on
        Index splat;
        float opacity;
        bool operator<(const Hit& other) const {
            return depth != other.depth ? depth < other.depth : splat < other.splat;
        }
    };

    /// Each splat counts where it is densest on the line.
    void find_hits(Vec3d place, Vec3f normal, float thinnest) {
        hits_.clear();
        const Vec3d outwards = vec_cast<double>(normal), step = outwards * grid_.step();
        grid_.find_splats(place + step * kBefore, place - step * kBehind, candidates_);
        const auto first = static_cast<float>(-kBefore * grid_.step()),
                   last = static_cast<float>(kBehind * grid_.step());
        for (const Index i : candidates_) {
            const Splat& s = splats_.items[i];
            // In doubles: small differences of large squares where splats are small.
            const Vec3d from = place - s.center;
            double aa = 0.0, ab = 0.0, bb = 0.0;
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3d axis = vec_cast<double>(s.axes[k]) /
                                   static_cast<double>(std::max(s.sigmas[k], thinnest));
                const double a = -dot(axis, outwards), b = dot(axis, from);
                aa += a * a, ab += a * b, bb += b * b;
            }
            const auto depth = static_cast<float>(-ab / aa),
                       q = static_cast<float>(std::max(bb - ab * ab / aa, 0.0));
            if (!(depth >= first && depth <= last && q < kCut2)) continue;
            const float opacity = s.opacity * gaussian(q);
            if (opacity >= kLeastSeen) hits_.push_back({depth, i, opacity});
        }
    }

    const PointCloud& cloud_;
    const Splats& splats_;
    const SplatGrid& grid_;
    std::vector<Hit> hits_;
    std::vector<Index> candidates_;
};

void measure_vertices(SplatSurface& out) {
    const std::vector<Vec3d>& x = out.mesh.positions;
    std::vector<Vec3d> areas(x.size());
    out.cloud.areas.assign(x.size(), 0.0F);
    for (const Triangle& t : out.mesh.triangles) {
        const Vec3d area = cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]) * 0.5;
        for (const Index v : t) {
            areas[v] += area;
            out.cloud.areas[v] += static_cast<float>(length(area) / 3.0);
        }
    }
    out.cloud.normals.resize(x.size());
    for (std::size_t v = 0; v < x.size(); ++v) {
        const double size = length(areas[v]);
        if (size > 0.0) out.cloud.normals[v] = vec_cast<float>(areas[v] / size);
    }
    out.cloud.given_normals.assign(x.size(), 1);
}

/// Moves each value towards the mean of those around it, by a share of the way.
template <class T>
void average_in_place(std::vector<T>& values, std::span<const Triangle> triangles, double share) {
    std::vector<T> sums(values.size(), T{});
    std::vector<double> counts(values.size(), 0.0);
    for (const Triangle& t : triangles)
        for (std::size_t k = 0; k < 3; ++k) sums[t[k]] += values[t[(k + 1) % 3]], ++counts[t[k]];
    for (std::size_t v = 0; v < values.size(); ++v)
        values[v] += (sums[v] / counts[v] - values[v]) * share;
}

/// Vertices that bridge gaps see nothing: they take the mean colour of those around them, from the
/// seen ones on, and the row of one.
void color_unseen_in_place(SplatSurface& out, std::vector<std::uint8_t> is_seen,
                           const Context& context) {
    PointCloud& cloud = out.cloud;
    for (bool changed = true; changed;) {
        check_cancelled(context);
        changed = false;
        std::vector<Vec3d> sums(cloud.size());
        std::vector<double> counts(cloud.size(), 0.0);
        for (const Triangle& t : out.mesh.triangles)
            for (std::size_t k = 0; k < 3; ++k) {
                const Index to = t[k], from = t[(k + 1) % 3];
                if (is_seen[to] || !is_seen[from]) continue;
                ++counts[to];
                cloud.rows[to] = cloud.rows[from];
                if (cloud.colors.empty()) continue;
                const Rgb16 c = cloud.colors[from];
                sums[to] += vec_cast<double>(Vec3<std::uint16_t>{c.r, c.g, c.b});
            }
        for (std::size_t v = 0; v < cloud.size(); ++v) {
            if (counts[v] == 0.0) continue;
            is_seen[v] = 1;
            changed = true;
            if (cloud.colors.empty()) continue;
            const Vec3d mean = sums[v] / counts[v] + Vec3d{0.5, 0.5, 0.5};
            cloud.colors[v] = {static_cast<std::uint16_t>(mean.x),
                               static_cast<std::uint16_t>(mean.y),
                               static_cast<std::uint16_t>(mean.z)};
        }
    }
}

/// The surface lies before the middle of the splats, by half a thickness of them and more.
void sink_in_place(SplatSurface& out, std::vector<double> depths, const Context& context) {
    for (int round = 0; round < kSmoothings; ++round)
        average_in_place(depths, out.mesh.triangles, 0.5);
    for (std::size_t v = 0; v < depths.size(); ++v)
        out.mesh.positions[v] -= vec_cast<double>(out.cloud.normals[v]) * (kSunk * depths[v]);
    // [Taubin95]: rough, but not smaller.
    for (int round = 0; round < kSmoothings; ++round) {
        check_cancelled(context);
        average_in_place(out.mesh.positions, out.mesh.triangles, 0.5);
        average_in_place(out.mesh.positions, out.mesh.triangles, -0.53);
    }
    out.cloud.positions = out.mesh.positions;
    measure_vertices(out);
}

}  // namespace

SplatSurface splat_surface(const PointCloud& cloud, const Context& context) {
    const Splats splats = splats_of(cloud);
    SplatSurface out;
    out.wanted_step = kStepOverSigma * median_size(splats.items);
    const SplatGrid grid(splats.items, out.wanted_step, context);
    out.step = grid.step();
    const Mesh contour = Contouring(grid, context).run();
    if (contour.triangles.empty())
        fail(ErrorCode::kDegenerate, "the {} splats are nowhere opaque enough for a surface",
             cloud.size());
    out.mesh = without_crumbs(contour);
    const std::size_t n = out.mesh.positions.size();
    out.cloud.positions = out.mesh.positions;
    measure_vertices(out);
    out.cloud.rows.resize(n);
    std::vector<double> depths(n);
    std::vector<std::uint8_t> is_seen(n);
    if (!cloud.colors.empty()) out.cloud.colors.resize(n);
    parallel_for(context, n, kGrain, [&](std::size_t begin, std::size_t end) {
        Viewer viewer(cloud, splats, grid);
        for (std::size_t v = begin; v < end; ++v) {
            const Viewer::View view =
                viewer.from_outside(out.mesh.positions[v], out.cloud.normals[v]);
            depths[v] = std::clamp(static_cast<double>(view.depth), 0.0, kMostSunk * grid.step());
            if (!cloud.colors.empty()) out.cloud.colors[v] = view.color;
            is_seen[v] = view.point != kInvalidIndex;
            out.cloud.rows[v] = cloud.rows[view.point == kInvalidIndex ? 0 : view.point];
        }
    });
    color_unseen_in_place(out, std::move(is_seen), context);
    sink_in_place(out, std::move(depths), context);
    out.cloud.frame = cloud.frame;
    out.cloud.num_rows = cloud.num_rows;
    out.cloud.dropped = cloud.dropped;
    out.cloud.merged = cloud.merged;
    return out;
}

}  // namespace pointbake
