// The stage: one triangulation, one run of Cocone, then the surface it gives with borders or the
// one that Tight Cocone closes. `auto` looks at both.
#include "pointbake/reconstruct.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>

#include "core/adjacency.h"
#include "core/message.h"
#include "core/noise.h"
#include "core/parallel.h"
#include "reconstruct/borders.h"
#include "reconstruct/cocone.h"
#include "reconstruct/delaunay.h"
#include "reconstruct/facet_surface.h"
#include "reconstruct/facing.h"
#include "reconstruct/flat.h"
#include "reconstruct/front.h"
#include "reconstruct/holes.h"
#include "reconstruct/implicit_method.h"
#include "reconstruct/open_surface.h"
#include "reconstruct/pieces.h"
#include "reconstruct/reach.h"
#include "reconstruct/robust_cocone.h"
#include "reconstruct/spacing.h"
#include "reconstruct/tetrahedra.h"
#include "reconstruct/thin.h"
#include "reconstruct/tight_cocone.h"

namespace pointbake {
namespace {

constexpr std::string_view kStage = "reconstruct";
// auto: a surface is closed if Tight Cocone had to add at most this share of its area ...
constexpr double kMaxAdded = 0.15;
// ... and left out at most this share of what Cocone found (double walls, hidden sheets).
constexpr double kMaxLost = 0.05;
// ... but where a closed one was asked for it may lose more.
constexpr double kMostLost = 0.5;
// Points nearer to each other than this share of the spacing do not both become vertices: a
// multiple of the noise, from duplicates up to half a spacing.
constexpr double kNearestPerNoise = 25.0, kLeastNearest = 0.02, kMostNearest = 0.5;
// What smooth parts of the surface may lose by thinning, in spacings; or the noise, if that is
// more.
constexpr double kTolerance = 0.02;

bool is_closing(Method method) {
    return method == Method::kTightCocone || method == Method::kRobustCocone ||
           method == Method::kOpacity;
}

Surface wanted_surface(const ReconstructOptions& options) {
    if (options.method == Method::kCocone) return Surface::kOpen;
    return is_closing(options.method) ? Surface::kWatertight : options.surface;
}

// The one point, and what became of the others: "1 point left of 20 rows (19 outside of --crop)".
std::string fate_of_points(const PointCloud& cloud) {
    std::string fates;
    const auto append = [&](std::ptrdiff_t count, std::string_view fate) {
        if (count > 0) fates += fmt::format("{}{} {}", fates.empty() ? "" : ", ", count, fate);
    };
    const auto append_dropped = [&](DropReason reason, std::string_view fate) {
        append(std::ranges::count(cloud.dropped, reason, &DroppedPoint::reason), fate);
    };
    append(std::ssize(cloud.merged), "with the coordinates of another");
    append_dropped(DropReason::kNonFinite, "with NaN or infinite coordinates");
    append_dropped(DropReason::kUnreadable, "that are not numbers");
    append_dropped(DropReason::kNoReturn, "without a return");
    append_dropped(DropReason::kNoSurfel, "of splats that are no surfels");
    append_dropped(DropReason::kWithheld, "that the file withholds");
    append_dropped(DropReason::kOutlier, "by --outliers drop");
    append_dropped(DropReason::kFloating, "by --floaters drop");
    append_dropped(DropReason::kCropped, "outside of --crop");
    append_dropped(DropReason::kSubsampled, "nearer than --subsample");
    const std::string count =
        cloud.size() == 1 ? "1 point" : fmt::format("{} points", cloud.size());
    if (fates.empty()) return count;
    return fmt::format("{} left of {} rows ({})", count, cloud.num_rows, fates);
}

void check_positions(const PointCloud& cloud) {
    if (cloud.size() < 3)
        fail(ErrorCode::kDegenerate, "{}: a surface needs at least 3 that are not on a line",
             fate_of_points(cloud));
    if (cloud.size() >= kInvalidIndex - 1)
        fail(ErrorCode::kLimit, "{} points: at most {} can be reconstructed at once", cloud.size(),
             kInvalidIndex - 2);
    for (std::size_t i = 0; i < cloud.size(); ++i)
        if (!is_finite(cloud.positions[i]))
            fail(ErrorCode::kInvalidInput, "point {} has a coordinate that is not finite", i);
}

// Throws where they shall enclose something and cannot.
FlatFrame checked_plane(const PointCloud& cloud, Surface wanted) {
    const FlatFrame frame = find_plane(cloud.positions);
    if (frame.is_flat && wanted == Surface::kWatertight)
        fail(ErrorCode::kDegenerate,
             "the points lie in a plane, which no watertight surface can have; use --surface open");
    return frame;
}

double area_of(const Tetrahedra& tets, const std::vector<HalfFacet>& facets,
               const std::vector<std::uint8_t>& marked, bool value) {
    double area = 0.0;
    for (HalfFacet f : facets)
        if ((marked[f] != 0) == value) area += 0.5 * length(tets.area_vector(f));
    return area;
}

std::vector<std::uint8_t> mark(const Tetrahedra& tets, const std::vector<HalfFacet>& facets) {
    std::vector<std::uint8_t> marked(tets.cells.size() * 4, 0);
    for (HalfFacet f : facets) marked[f] = marked[tets.mirror(f)] = 1;
    return marked;
}

// Drops the pieces that are not worth keeping, and the vertices that only they used.
void drop_flakes(const Tetrahedra& tets, std::span<const float> spacing, IndexedSurface& surface) {
    std::vector<Triangle> triangles = surface.triangles;
    for (Triangle& t : triangles)
        for (Index& v : t) v = surface.vertex_points[v];
    const Pieces pieces = find_pieces(triangle_neighbors(surface.triangles));
    const auto is_kept = choose_pieces(tets, spacing, triangles, pieces);
    std::vector<Triangle> kept;
    for (std::size_t p = 0; p < pieces.size(); ++p)
        if (is_kept[p] != 0)
            for (Index t : pieces.of(p)) kept.push_back(surface.triangles[t]);
    surface.triangles = std::move(kept);
    drop_unused_vertices(surface);
}

// In cloud units; nothing if it was not told.
std::optional<double> hole_size(const ReconstructOptions& options, const PointCloud& cloud) {
    if (!options.fill_holes) return std::nullopt;
    Box box;
    for (const Vec3d& p : cloud.positions) box.extend(p);
    return options.fill_holes->in_units(box.diagonal());
}

// The holes of an implicit surface: its vertices are no points.
void fill_holes(const PointCloud& cloud, const ReconstructOptions& options,
                ReconstructResult& result, const Context& context) {
    const auto size = hole_size(options, cloud);
    if (!size || result.report.surface != Surface::kOpen) return;
    Mesh& mesh = result.surface.mesh;
    IndexedSurface indexed{std::vector<Index>(mesh.positions.size()), std::move(mesh.triangles)};
    result.report.num_holes_filled =
        fill_holes_in_place(mesh.positions, {}, {.size = size}, indexed, context);
    mesh.triangles = std::move(indexed.triangles);
}

// How the closed surface differs from the one that Cocone found.
struct Difference {
    double added = 0.0, lost = 0.0;  // shares of the closed surface's and of the open one's area
};

Difference compare(const Tetrahedra& tets, const FacetSurface& open, const FacetSurface& closed) {
    Difference d;
    const auto in_open = mark(tets, open.facets), in_closed = mark(tets, closed.facets);
    const double added = area_of(tets, closed.facets, in_open, false);
    const double common = area_of(tets, closed.facets, in_open, true);
    const double lost = area_of(tets, open.facets, in_closed, false);
    d.added = added + common > 0 ? added / (added + common) : 1.0;
    d.lost = lost + common > 0 ? lost / (lost + common) : 1.0;
    return d;
}

class Stage {
 public:
    Stage(const PointCloud& cloud, const ReconstructOptions& options, const Context& context)
        : cloud_(cloud),
          context_(context),
          options_(options),
          wanted_(wanted_surface(options)),
          is_robust_(options.method == Method::kRobustCocone),
          is_flat_(false) {}

    ReconstructResult run() {
        report_progress(context_, kStage, 0.0);
        const FlatFrame frame = checked_plane(cloud_, wanted_);
        is_flat_ = frame.is_flat;
        tets_ = triangulate(is_flat_ ? project(cloud_.positions, frame) : cloud_.positions);
        if (is_robust_) keep_outer_points();
        report_progress(context_, kStage, 0.5);
        const Cocone cocone = find_cocone(tets_, context_);
        report_.num_flat = cocone.num_flat;
        report_progress(context_, kStage, 0.7);
        FacetSurface surface = extract_open(tets_, cocone, is_or_was_noisy(), context_);
        report_progress(context_, kStage, 0.8);
        choose(cocone, surface);
        if (report_.surface == Surface::kOpen) {
            grow_in_place(tets_, cocone.spacing, surface, context_);
            reach_.emplace(cloud_.positions);
            drop_far_facets(tets_, cocone.spacing, cloud_.positions, *reach_, surface, context_);
        }
        report_progress(context_, kStage, 0.9);
        return finish(cocone, std::move(surface));
    }

 private:
    bool is_or_was_noisy() const { return cloud_.noise >= kLeastNoise || !cloud_.measured.empty(); }

    // Of points that are not too near to each other.
    Tetrahedra triangulate(const std::vector<Vec3d>& points) {
        const ThinRule rule{
            std::clamp(kNearestPerNoise * cloud_.noise, kLeastNearest, kMostNearest),
            options_.thin == Thin::kOff ? 0.0 : std::max(cloud_.noise, kTolerance),
            options_.most_thinning};
        const std::vector<Index> kept = thin(points, rule, context_);
        report_.num_thinned = static_cast<Index>(points.size() - kept.size());
        std::vector<Vec3d> some;
        some.reserve(kept.size());
        for (Index i : kept) some.push_back(points[i]);
        Tetrahedra tets = tetrahedralize(some, context_);
        for (Index& id : tets.point_ids) id = kept[id];
        return tets;
    }

    // Tetrahedralizes anew what lies on the outer side of the noise.
    void keep_outer_points() {
        report_progress(context_, kStage, 0.3);
        const std::vector<Index> outer =
            outer_points(tets_, local_spacing(tets_, context_), context_);
        report_.num_left_out = tets_.num_real() - static_cast<Index>(outer.size());
        std::vector<Vec3d> points;
        for (Index v : outer) points.push_back(tets_.points[v]);
        Tetrahedra rest = tetrahedralize(points, context_);
        for (Index& id : rest.point_ids) id = tets_.point_ids[outer[id]];
        tets_ = std::move(rest);
    }

    std::string reason(const Difference& d, bool is_closed) const {
        if (wanted_ == Surface::kWatertight)
            return fmt::format(
                "asked for; closing adds {:.1f} % of the area and loses {:.1f} % of what was found",
                100 * d.added, 100 * d.lost);
        return fmt::format(
            "{} {:.1f} % of the area (limit {:.0f} %) and {} {:.1f} % of what was found (limit "
            "{:.0f} %)",
            is_closed ? "closing adds only" : "closing would add", 100 * d.added, 100 * kMaxAdded,
            is_closed ? "loses" : "lose", 100 * d.lost, 100 * kMaxLost);
    }

    // Replaces the open surface by the closed one where that is wanted.
    void choose(const Cocone& cocone, FacetSurface& surface) {
        report_.surface = Surface::kOpen;
        report_.method = Method::kCocone;
        if (is_flat_) {
            report_.reason = "the points lie in a plane";
            return;
        }
        if (wanted_ == Surface::kOpen) {
            report_.reason = "asked for";
            return;
        }
        InsideLabels labels = label_cells(tets_, cocone, surface, context_);
        FacetSurface closed = boundary_of(tets_, labels.inside, context_);
        const Difference d = compare(tets_, surface, closed);
        report_.num_poor = labels.num_poor;
        report_.num_conflicts = labels.num_conflicts;
        report_.added_area_fraction = d.added;
        const bool is_closed = !closed.facets.empty() && d.added <= kMaxAdded && d.lost <= kMaxLost;
        report_.reason = reason(d, is_closed) + fmt::format("; {} of {} points are poor",
                                                            labels.num_poor, tets_.num_real());
        if (wanted_ == Surface::kAuto && !is_closed) return;
        if (options_.method == Method::kAuto && (closed.facets.empty() || d.lost > kMostLost))
            throw TooLittleEnclosed(closed.facets.empty() ? 1.0 : d.lost);
        if (closed.facets.empty())
            fail(ErrorCode::kDegenerate,
                 "the points enclose nothing: no watertight surface; use --surface open");
        report_.surface = Surface::kWatertight;
        report_.method = is_robust_ ? Method::kRobustCocone : Method::kTightCocone;
        if (is_robust_)
            report_.reason += fmt::format("; {} points on the inner side of the noise are left out",
                                          report_.num_left_out);
        surface = std::move(closed);
    }

    ReconstructResult finish(const Cocone& cocone, FacetSurface surface) {
        if (surface.facets.empty())
            fail(ErrorCode::kDegenerate,
                 "no surface found through the {} points: they are too sparse or too noisy",
                 tets_.num_real());
        const bool is_open = report_.surface == Surface::kOpen;
        IndexedSurface indexed = split_fans(tets_, std::move(surface), is_open, context_);
        if (indexed.triangles.empty())
            fail(ErrorCode::kDegenerate, "the surface found touches itself everywhere");
        if (is_open) {
            drop_flakes(tets_, cocone.spacing, indexed);
            settle_borders(cocone.spacing, indexed);
        }
        const auto& of = indexed.vertex_points;
        report_.num_split_vertices = static_cast<Index>(std::inner_product(
            of.begin() + 1, of.end(), of.begin(), 0, std::plus<>(), std::equal_to<>()));
        ReconstructResult result;
        Mesh& mesh = result.surface.mesh;
        order_vertices(indexed);
        for (Index v : indexed.vertex_points) {
            mesh.positions.push_back(cloud_.positions[v]);
            result.surface.vertex_points.push_back(v);
        }
        mesh.triangles = std::move(indexed.triangles);
        result.report = std::move(report_);
        return result;
    }

    // Fills what should have no border, and trims what keeps one.
    void settle_borders(std::span<const float> spacing, IndexedSurface& surface) {
        std::vector<Vec3d> positions;
        std::vector<float> spacings;
        std::vector<Index> ids;
        for (Index v : surface.vertex_points) {
            ids.push_back(tets_.point_ids[v]);
            positions.push_back(cloud_.positions[ids.back()]);
            spacings.push_back(spacing[v]);
        }
        const HoleRule rule{hole_size(options_, cloud_), &*reach_};
        report_.num_holes_filled =
            fill_holes_in_place(positions, spacings, rule, surface, context_);
        trim_borders_in_place(positions, ids, *reach_, surface, context_);
    }

    // Vertices in the cloud's order, triangles by vertices with the smallest one first.
    void order_vertices(IndexedSurface& surface) const {
        const std::size_t n = surface.vertex_points.size();
        std::vector<Index> order(n), rank(n);
        for (Index v = 0; v < n; ++v) order[v] = v;
        for (Index& v : surface.vertex_points) v = tets_.point_ids[v];
        std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
            return surface.vertex_points[a] < surface.vertex_points[b];
        });
        std::vector<Index> points(n);
        for (Index k = 0; k < n; ++k) {
            rank[order[k]] = k;
            points[k] = surface.vertex_points[order[k]];
        }
        surface.vertex_points = std::move(points);
        for (Triangle& t : surface.triangles) {
            for (Index& v : t) v = rank[v];
            std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        }
        std::sort(surface.triangles.begin(), surface.triangles.end());
    }

    const PointCloud& cloud_;
    const Context& context_;
    const ReconstructOptions& options_;
    Surface wanted_;
    bool is_robust_, is_flat_;
    Tetrahedra tets_;
    std::optional<Reach> reach_;  // of an open surface
    ReconstructReport report_;
};

// What follows from the mesh.
void complete(ReconstructResult& result, std::size_t num_points, const Context& context) {
    ReconstructReport& report = result.report;
    const DenseMesh& surface = result.surface;
    const Topology t = topology(surface.mesh.positions.size(), surface.mesh.triangles);
    report.num_vertices = t.num_vertices;
    report.num_triangles = t.num_triangles;
    report.num_components = t.num_components;
    report.num_boundary_loops = t.num_boundary_loops;
    const Index num_used =
        surface.vertex_points.empty() ? 0 : t.num_vertices - report.num_split_vertices;
    report.num_unused = static_cast<Index>(num_points) - num_used;
    log(context, LogLevel::kInfo, "reconstruct: {}: {}; {} triangles, {} components, {} borders",
        to_word(report.surface), report.reason, t.num_triangles, t.num_components,
        t.num_boundary_loops);
    report_progress(context, kStage, 1.0);
}

}  // namespace

TooLittleEnclosed::TooLittleEnclosed(double lost)
    : Error(ErrorCode::kDegenerate,
            fmt::format("a watertight surface through the points would lose {:.1f} % of what was "
                        "found; use --method implicit or --surface open",
                        100 * lost)),
      lost_area_fraction(lost) {}

bool is_available(Method method) {
    return method == Method::kAuto || method == Method::kImplicit || method == Method::kOpacity ||
           has_delaunay();
}

void validate(const ReconstructOptions& options) {
    if (options.surface == Surface::kGiven) return;
    if ((options.surface == Surface::kOpen && is_closing(options.method)) ||
        (options.surface == Surface::kWatertight && options.method == Method::kCocone))
        fail(ErrorCode::kInvalidOption,
             "method '{}' does not make a surface that is '{}': cocone is for open surfaces, "
             "tight-cocone, robust-cocone and opacity for watertight ones; implicit makes both",
             to_word(options.method), to_word(options.surface));
    if (!is_available(options.method))
        fail(ErrorCode::kInvalidOption,
             "method '{}' needs CGAL's predicates, and this program is built without it: use "
             "implicit or auto, or build with -DPOINTBAKE_CGAL=ON",
             to_word(options.method));
    const auto& size = options.fill_holes;
    if (size && !(size->value >= 0.0 && std::isfinite(size->value)))
        fail(ErrorCode::kInvalidOption, "fill-holes is {}: a length of 0 or more is accepted",
             to_string(*size));
}

bool needs_normals(const ReconstructOptions& options) {
    return options.method == Method::kImplicit ||
           (options.method == Method::kAuto && !has_delaunay());
}

ReconstructResult reconstruct(const PointCloud& cloud, const ReconstructOptions& options,
                              const Context& context) {
    if (options.surface == Surface::kGiven)
        fail(ErrorCode::kInvalidOption,
             "surface 'given' takes the faces of the file: there is nothing to reconstruct; use "
             "auto, open or watertight");
    if (options.method == Method::kOpacity)
        fail(ErrorCode::kInvalidOption,
             "method 'opacity' is for Gaussian splats: points do not have their shapes");
    validate(options);
    check_positions(cloud);
    const bool is_implicit = needs_normals(options);
    if (is_implicit) checked_plane(cloud, options.surface);
    ReconstructResult result = is_implicit
                                   ? run_implicit(cloud, options.surface, kMaxAdded, context)
                                   : Stage(cloud, options, context).run();
    if (is_implicit)
        fill_holes(cloud, options, result, context);
    else if (result.report.surface == Surface::kOpen)
        face_in_place(cloud, result);
    complete(result, cloud.size(), context);
    return result;
}

}  // namespace pointbake
