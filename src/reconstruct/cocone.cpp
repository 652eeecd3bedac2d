// Based on [Amenta02] (co-cone test) and [Dey01] (flatness, boundary detection). Departures: the
// far points stand for infinity; the radius of a co-cone is taken where Voronoi edges cross the
// tangent plane; the expansion of the flat set goes in rounds over a frozen copy, so that no order
// matters. Circumcentres stay homogeneous: those of nearly flat cells are huge, and no test
// divides.
#include "reconstruct/cocone.h"

#include <algorithm>

#include "core/parallel.h"
#include "reconstruct/circumcenter.h"
#include "reconstruct/spacing.h"

namespace pointbake {
namespace {

constexpr double kSinTheta = 0.38268343236508977;  // sin(pi/8): half opening of the co-cone
constexpr double kRho = 1.0 / 1.2;                 // flat: co-cone radius <= rho * height
constexpr double kCosAlpha = 0.5;  // flat: normals of co-cone neighbours within 60 degrees
constexpr std::size_t kGrain = 1U << 11;

// A Voronoi vertex seen from a sample: at sample + dir / den.
struct Seen {
    Vec3d dir;
    double den;
};

struct Builder {
    const Tetrahedra& tets;
    const Context& context;
    std::vector<Circumcenter> centers;
    Cocone out;
    std::vector<std::uint8_t> ratio_holds;
    std::vector<std::int8_t> sides;  // per cell and vertex: where the Voronoi vertex lies for it

    Seen seen_from(Index cell, Vec3d p) const {
        return {direction_to(tets, cell, centers[cell], p), centers[cell].den};
    }

    // -1, 0, +1: below, inside or above the co-cone of a sample with this normal.
    static std::int8_t side(const Seen& y, Vec3d normal) {
        const double a = dot(y.dir, normal);
        if (a * a <= kSinTheta * kSinTheta * squared_length(y.dir)) return 0;
        return a > 0 ? 1 : -1;
    }
    std::int8_t side_of(Index cell, Index v) const { return sides[cell * 4 + tets.slot(cell, v)]; }
    // Outside the co-cone lie two convex nappes: an edge with both ends in one stays there, one
    // with ends in different ones crosses.
    static bool meets(std::int8_t side_a, std::int8_t side_b) {
        return side_a == 0 || side_a != side_b;
    }

    void compute_centers() {
        centers.resize(tets.cells.size());
        parallel_for(context, centers.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t c = begin; c < end; ++c)
                centers[c] = circumcenter(tets, static_cast<Index>(c));
        });
    }

    // The pole's direction, and the height: how far the Voronoi cell reaches to the other side.
    double find_pole(Index v, std::vector<Seen>& seen) {
        const Vec3d p = tets.points[v];
        seen.clear();
        double farthest = -1.0;
        Vec3d normal;
        for (Index c : tets.star(v)) {
            const Seen y = seen_from(c, p);
            const double r2 = squared_length(y.dir) / (y.den * y.den);
            if (r2 > farthest) farthest = r2, normal = y.dir;
            seen.push_back(y);
        }
        out.normals[v] = normal = normalized(normal);
        double height2 = 0.0;
        for (const Seen& y : seen)
            if (dot(y.dir, normal) < 0)
                height2 = std::max(height2, squared_length(y.dir) / (y.den * y.den));
        return height2;
    }

    // Calls body(cell, other cell, facet's slot in cell) for each facet at v whose dual edge meets
    // the co-cone of v.
    template <class Body>
    void for_each_accepted(Index v, Body&& body) const {
        for (Index c : tets.star(v)) {
            const std::int8_t own = side_of(c, v);
            for (std::size_t i = 0; i < 4; ++i) {
                const Index n = tets.neighbors[c][i];
                if (tets.cells[c][i] == v || n < c || n == kInvalidIndex) continue;
                if (meets(own, side_of(n, v))) body(c, n, i);
            }
        }
    }

    // Squared distance from v to where a Voronoi edge crosses its tangent plane; 0 if it does not.
    double crossing_distance2(Index v, Index c, Index n) const {
        const Vec3d p = tets.points[v], normal = out.normals[v];
        const Seen y1 = seen_from(c, p), y2 = seen_from(n, p);
        const double a1 = dot(y1.dir, normal), a2 = dot(y2.dir, normal);
        if ((a1 > 0) == (a2 > 0)) return 0.0;
        const double den = a1 * y2.den - a2 * y1.den;
        if (den == 0) return 0.0;
        return squared_length(y2.dir * a1 - y1.dir * a2) / (den * den);
    }

    void measure_cocone(Index v, double height2) {
        double radius2 = 0.0;
        for_each_accepted(v, [&](Index c, Index n, std::size_t) {
            radius2 = std::max(radius2, crossing_distance2(v, c, n));
        });
        ratio_holds[v] = radius2 <= kRho * kRho * height2 ? 1 : 0;
    }

    void measure_vertices() {
        out.normals.resize(tets.num_real());
        ratio_holds.resize(tets.num_real());
        sides.resize(tets.cells.size() * 4);
        parallel_for(context, tets.num_real(), kGrain, [&](std::size_t begin, std::size_t end) {
            std::vector<Seen> seen;
            for (Index v = static_cast<Index>(begin); v < end; ++v) {
                const double height2 = find_pole(v, seen);
                const auto star = tets.star(v);
                for (std::size_t k = 0; k < star.size(); ++k)
                    sides[star[k] * 4 + tets.slot(star[k], v)] = side(seen[k], out.normals[v]);
                measure_cocone(v, height2);
            }
        });
    }

    bool agrees(Index v, Index q) const {
        return std::abs(dot(out.normals[v], out.normals[q])) >= kCosAlpha;
    }

    // [Dey01]: first the points whose whole neighbourhood agrees, then those next to one of them.
    void find_flat() {
        out.flat.assign(tets.num_real(), 0);
        parallel_for(context, tets.num_real(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (Index v = static_cast<Index>(begin); v < end; ++v) {
                if (ratio_holds[v] == 0) continue;
                bool all = true;
                for_each_accepted(v, [&](Index c, Index, std::size_t i) {
                    for (std::size_t k = 0; k < 4; ++k) {
                        const Index q = tets.cells[c][k];
                        if (k != i && q != v && !tets.is_far(q) && !agrees(v, q)) all = false;
                    }
                });
                out.flat[v] = all ? 1 : 0;
            }
        });
        expand_flat();
    }

    void expand_flat() {
        std::vector<Index> pending;
        for (Index v = 0; v < tets.num_real(); ++v)
            if (ratio_holds[v] != 0 && out.flat[v] == 0) pending.push_back(v);
        std::vector<std::uint8_t> joins;
        for (bool changed = true; changed;) {
            joins.assign(pending.size(), 0);
            parallel_for(context, pending.size(), 256, [&](std::size_t begin, std::size_t end) {
                for (std::size_t k = begin; k < end; ++k) joins[k] = has_flat_ally(pending[k]);
            });
            changed = false;
            std::vector<Index> rest;
            for (std::size_t k = 0; k < pending.size(); ++k) {
                if (joins[k] == 0)
                    rest.push_back(pending[k]);
                else
                    out.flat[pending[k]] = 1, changed = true;
            }
            pending = std::move(rest);
        }
        out.num_flat = static_cast<Index>(std::count(out.flat.begin(), out.flat.end(), 1));
    }

    std::uint8_t has_flat_ally(Index v) const {
        bool found = false;
        for_each_accepted(v, [&](Index c, Index, std::size_t i) {
            for (std::size_t k = 0; k < 4; ++k) {
                const Index q = tets.cells[c][k];
                if (k != i && q != v && !tets.is_far(q) && out.flat[q] != 0 && agrees(v, q))
                    found = true;
            }
        });
        return found ? 1 : 0;
    }

    std::uint8_t judge_facet(Index c, Index n, std::size_t i) const {
        bool any_flat = false, flat_accept = true, all_accept = true;
        for (std::size_t k : kFacetCorners[i]) {
            const Index v = tets.cells[c][k];
            if (tets.is_far(v)) return 0;
            const bool accepts = meets(side_of(c, v), side_of(n, v));
            any_flat |= out.flat[v] != 0;
            all_accept &= accepts;
            flat_accept &= accepts || out.flat[v] == 0;
            if (!all_accept && !flat_accept) return 0;
        }
        return static_cast<std::uint8_t>((any_flat && flat_accept ? kSurfaceFacet : 0) |
                                         (all_accept ? kAgreedFacet : 0));
    }

    void judge_facets() {
        out.facets.assign(tets.cells.size() * 4, 0);
        parallel_for(context, tets.cells.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (Index c = static_cast<Index>(begin); c < end; ++c) {
                for (std::size_t i = 0; i < 4; ++i) {
                    const Index n = tets.neighbors[c][i];
                    if (n < c || n == kInvalidIndex) continue;
                    const HalfFacet facet = c * 4 + static_cast<Index>(i);
                    const std::uint8_t flags = judge_facet(c, n, i);
                    out.facets[facet] = flags;
                    out.facets[tets.mirror(facet)] = flags;
                }
            }
        });
    }
};

}  // namespace

Cocone find_cocone(const Tetrahedra& tets, const Context& context) {
    Builder builder{tets, context, {}, {}, {}, {}};
    builder.compute_centers();
    builder.measure_vertices();
    builder.out.spacing = local_spacing(tets, context);
    builder.find_flat();
    builder.judge_facets();
    return std::move(builder.out);
}

}  // namespace pointbake
