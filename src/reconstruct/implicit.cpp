// After [Hoppe92]; what each step departs in is said in the files that it is in.
#include "reconstruct/implicit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "reconstruct/contour.h"
#include "reconstruct/field_grid.h"
#include "reconstruct/membrane.h"
#include "reconstruct/signed_distance.h"
#include "reconstruct/surface_parts.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 4096;

// Where the density falls below this there is no surface: a third of a spacing beyond a straight
// border. Lower than a half, so that chance makes no holes in random samples.
constexpr float kLeastDensity = 0.4F;
// Height above the surface, in spacings, up to which the field's sign is trusted. Farther up
// another sheet may be as near.
constexpr float kTrustedHeight = 4.0F;
// A root is one if the field is that small there, in spacings; elsewhere its sign jumps, half way
// between two sheets that face the same way.
constexpr float kRootTolerance = 0.25F;
// The search for a root ends here.
constexpr float kGoodRoot = 0.005F;
constexpr int kRootSteps = 3;
// Normals that turn by less than this along an edge (20 degrees) leave a cubic no room for errors.
constexpr float kSmoothTurn = 0.35F;
constexpr int kNewtonSteps = 3;

/// Mesh vertices with what the field says there.
struct Vertices {
    std::vector<Vec3d> positions;
    std::vector<FieldSample> samples;
};

bool is_root(const FieldSample& s) {
    return s.is_known && std::abs(s.value) <= kRootTolerance * s.spacing;
}

bool is_trusted(const FieldSample& s, double noise) {
    return s.is_known && s.density >= kLeastDensity &&
           std::abs(s.value) <= (kTrustedHeight + static_cast<float>(noise)) * s.spacing;
}

bool is_smooth(const FieldSample& a, const FieldSample& b) {
    return !a.is_bent && !b.is_bent &&
           squared_length(a.normal - b.normal) < kSmoothTurn * kSmoothTurn;
}

/// Where on an edge from a to b, as a share of it, the cubic is 0 that has the samples' values and
/// slopes at the ends; NaN if it does not fall all the way. Values are positive at a, negative at
/// b.
double cubic_root(const FieldSample& a, const FieldSample& b, Vec3d edge) {
    const double fall = double{b.value} - a.value;
    const double slope_a = dot(vec_cast<double>(a.normal), edge);
    const double slope_b = dot(vec_cast<double>(b.normal), edge);
    // [Fritsch80]
    if (std::max(slope_a, slope_b) >= 0.0 || std::min(slope_a, slope_b) < 3.0 * fall)
        return std::numeric_limits<double>::quiet_NaN();
    const double c2 = 3.0 * fall - 2.0 * slope_a - slope_b, c3 = slope_a + slope_b - 2.0 * fall;
    double t = a.value / -fall;
    for (int step = 0; step < kNewtonSteps; ++step) {
        const double value = a.value + t * (slope_a + t * (c2 + t * c3));
        const double slope = slope_a + t * (2.0 * c2 + t * 3.0 * c3);
        t = std::clamp(t - value / std::min(slope, 0.25 * fall), 0.0, 1.0);
    }
    return t;
}

class Extraction {
 public:
    Extraction(const SignedDistance& field, const FieldGrid& sampled, bool is_closed,
               const Context& context)
        : field_(field), is_closed_(is_closed), context_(context), sampled_(sampled) {}

    Mesh run() {
        assign_values();
        const Contour contour = find_contour(sampled_.grid, values_, is_trusted_, context_);
        const Vertices vertices = place_vertices(contour);
        Mesh mesh;
        mesh.positions = vertices.positions;
        mesh.triangles = contour.triangles;
        std::vector<float> support(mesh.positions.size());
        for (std::size_t i = 0; i < support.size(); ++i) {
            const FieldSample& s = vertices.samples[i];
            support[i] = is_root(s) ? s.density - kLeastDensity : -kLeastDensity;
        }
        if (!is_closed_) return trim(mesh, support);
        smooth_unsupported_in_place(mesh, support);
        return keep_supported_pieces(std::move(mesh), support);
    }

 private:
    /// Values per node: the field's, and between them those of a membrane if the surface is closed.
    void assign_values() {
        const SimplexGrid& grid = sampled_.grid;
        values_.assign(grid.num_nodes(), std::numeric_limits<float>::quiet_NaN());
        is_trusted_.assign(grid.num_nodes(), 0);
        for (Index i = 0; i < grid.num_nodes(); ++i) {
            const FieldSample& s = sampled_.samples[i];
            is_trusted_[i] = is_trusted(s, field_.noise());
            if (s.is_known && (is_trusted_[i] || !is_closed_)) values_[i] = s.value / s.spacing;
        }
        if (!is_closed_) return;
        std::vector<std::uint8_t> is_given = is_trusted_;
        for (Index i = 0; i < grid.num_nodes(); ++i) {
            if (grid.is_on_boundary(i)) values_[i] = 1.0F, is_given[i] = 1;
            // Only the side counts: near the points the function is as steep on both.
            if (is_given[i]) values_[i] = std::clamp(values_[i], -1.0F, 1.0F);
        }
        span_membrane_in_place(grid, is_given, values_, context_);
    }

    Vertices place_vertices(const Contour& contour) const {
        const std::size_t count = contour.vertices.size();
        std::vector<Search> searches(count);
        parallel_for(context_, count, kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                searches[i] = start_search(contour.vertices[i]);
        });
        run_searches(searches);
        Vertices out;
        for (const Search& s : searches) {
            out.positions.push_back(s.place);
            out.samples.push_back(s.sample);
        }
        return out;
    }

    /// For the surface: along an edge by regula falsi, or from a grid vertex along the normal.
    struct Search {
        Vec3d outside, inside;  ///< the ends of what is left of the edge, if any
        double at_outside = 0.0, at_inside = 0.0;
        bool is_on_edge = true, is_done = false;
        bool is_found = false;  ///< from the grid's samples alone
        Vec3d place;
        FieldSample sample;

        void cut() {
            place = outside + (inside - outside) * (at_outside / (at_outside - at_inside));
        }
        void step() {
            if (!is_on_edge) {
                place -= vec_cast<double>(sample.normal * sample.value);
            } else {
                (sample.value < 0.0F ? inside : outside) = place;
                (sample.value < 0.0F ? at_inside : at_outside) = sample.value;
                cut();
            }
        }
    };

    Search start_search(const ContourVertex& v) const {
        const FieldSample &at_outside = sampled_.samples[v.outside],
                          &at_inside = sampled_.samples[v.inside];
        Search s;
        s.outside = sampled_.grid.place(v.outside);
        s.inside = sampled_.grid.place(v.inside);
        if (v.is_snapped()) {
            s.is_on_edge = false;
            s.place = s.outside;
            s.sample = at_outside;
            s.step();
            s.is_found = !at_outside.is_bent;
            s.sample.value = 0.0F;
            return s;
        }
        s.at_outside = values_[v.outside];
        s.at_inside = values_[v.inside];
        s.is_done = !agrees(v.outside) || !agrees(v.inside);
        if (s.is_done) return s.cut(), s;
        s.at_outside = at_outside.value;
        s.at_inside = at_inside.value;
        s.cut();
        if (!is_smooth(at_outside, at_inside)) return s;
        const double share = cubic_root(at_outside, at_inside, s.inside - s.outside);
        if (std::isnan(share)) return s;
        s.is_found = true;
        s.place = s.outside + (s.inside - s.outside) * share;
        s.sample = at_outside;
        s.sample.value = 0.0F;
        s.sample.density =
            std::lerp(at_outside.density, at_inside.density, static_cast<float>(share));
        return s;
    }

    /// All at once: that is what the field is fast at. Those that were done at their start are only
    /// sampled, those found not even that.
    void run_searches(std::span<Search> searches) const {
        std::vector<Search*> active;
        for (Search& s : searches)
            if (!s.is_found) active.push_back(&s);
        for (int step = 1; !active.empty(); ++step) {
            std::vector<Vec3d> places;
            for (const Search* s : active) places.push_back(s->place);
            const std::vector<FieldSample> samples = field_.at(places, context_);
            for (std::size_t i = 0; i < active.size(); ++i) active[i]->sample = samples[i];
            std::erase_if(active, [&](const Search* s) {
                return s->is_done || step == kRootSteps || !s->sample.is_known ||
                       std::abs(s->sample.value) <= kGoodRoot * s->sample.spacing;
            });
            for (Search* s : active) s->step();
        }
    }

    /// Whether the field has the sign of the value.
    bool agrees(Index node) const {
        const FieldSample& s = sampled_.samples[node];
        return s.is_known && (s.value < 0.0F) == (values_[node] < 0.0F);
    }

    const SignedDistance& field_;
    bool is_closed_;
    const Context& context_;
    const FieldGrid& sampled_;
    std::vector<float> values_;
    std::vector<std::uint8_t> is_trusted_;
};

}  // namespace

struct ImplicitSurface::Sampled {
    SignedDistance field;
    FieldGrid grid;
};

ImplicitSurface::ImplicitSurface(const ImplicitInput& input, const Context& context) {
    SignedDistance field(input.points, input.normals, input.spacing, input.noise, context);
    if (field.size() == 0) return;
    FieldGrid grid = sample_adaptively(field, context);
    sampled_ = std::make_unique<Sampled>(Sampled{std::move(field), std::move(grid)});
}
ImplicitSurface::~ImplicitSurface() = default;

Mesh ImplicitSurface::mesh(bool is_closed, const Context& context) const {
    if (!sampled_) return {};
    return Extraction(sampled_->field, sampled_->grid, is_closed, context).run();
}

Mesh implicit_surface(const ImplicitInput& input, bool is_closed, const Context& context) {
    return ImplicitSurface(input, context).mesh(is_closed, context);
}

}  // namespace pointbake
