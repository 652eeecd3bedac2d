// Stage 3: points become a dense triangle mesh, over (a subset of) them or between them.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/error.h"
#include "pointbake/options.h"
#include "pointbake/types.h"

namespace pointbake {

enum class Surface { kAuto, kOpen, kWatertight, kGiven };
template <>
struct EnumWords<Surface> {
    static constexpr std::string_view words[] = {"auto", "open", "watertight", "given"};
};
enum class Method { kAuto, kCocone, kTightCocone, kRobustCocone, kImplicit, kOpacity };
template <>
struct EnumWords<Method> {
    static constexpr std::string_view words[] = {"auto",          "cocone",   "tight-cocone",
                                                 "robust-cocone", "implicit", "opacity"};
};

enum class Thin { kAuto, kOff };
template <>
struct EnumWords<Thin> {
    static constexpr std::string_view words[] = {"auto", "off"};
};

struct ReconstructOptions {
    Surface surface = Surface::kAuto;
    Method method = Method::kAuto;
    Thin thin = Thin::kAuto;
    std::optional<Length> fill_holes = {};
    /// Farthest that thinning may take the surface from a point, in cloud units. No option of its
    /// own: convert() takes a share of the geometry bound.
    double most_thinning = HUGE_VAL;
    template <class Field>
    static void describe(Field&& field) {
        field("surface", &ReconstructOptions::surface,
              "what the surface is: open, watertight, the faces given in the file, or auto");
        field(
            "method", &ReconstructOptions::method,
            "how it is found: cocone (open), tight-cocone (watertight), robust-cocone (watertight, "
            "around the noise), implicit (open or watertight, between the points), opacity "
            "(watertight, around Gaussian splats), or auto");
        field("thin", &ReconstructOptions::thin,
              "which points become vertices of the dense mesh: auto (fewer where the surface "
              "bends little; it stays within 0.02 spacings) or off (all of them)");
        field(
            "fill-holes", &ReconstructOptions::fill_holes,
            "open surfaces: fill holes of at most this diameter, in the file's unit, as 2mm or as "
            "1% of the diagonal; 0 fills none (default: gaps of about 6 spacings)");
    }
};

struct ReconstructReport {
    Surface surface = Surface::kAuto;  ///< what was chosen, never kAuto
    Method method = Method::kAuto;     ///< likewise
    std::string reason;                ///< one line with the figures behind the choice
    Index num_vertices = 0, num_triangles = 0;
    Index num_components = 0, num_boundary_loops = 0;
    Index num_flat = 0;                ///< points that Cocone calls flat (well sampled)
    Index num_poor = 0;                ///< points without a good umbrella
    Index num_conflicts = 0;           ///< tetrahedra that got both labels
    Index num_left_out = 0;            ///< points that Robust Cocone finds inside the noise
    Index num_thinned = 0;             ///< points that the shape does not need as vertices
    Index num_unused = 0;              ///< points that are no vertex of the surface, thinned or not
    Index num_turned_pieces = 0;       ///< of an open surface, by sensors or the file's normals
    Index num_holes_filled = 0;        ///< borders closed of an open surface
    Index num_splat_points = 0;        ///< opacity: points that stand for the splats from there on
    Index num_split_vertices = 0;      ///< copies made so that the surface is 2-manifold
    double added_area_fraction = 0.0;  ///< share of the watertight surface that Cocone did not find
};

struct ReconstructResult {
    DenseMesh surface;
    std::vector<Index> unsure_normals;  ///< points whose given normals contradict each other:
                                        ///< no side was taken from them, convert estimates them
    ReconstructReport report;
};

/// Sheets enclose next to nothing: the implicit method, which wants normals, goes around them.
class TooLittleEnclosed : public Error {
 public:
    explicit TooLittleEnclosed(double lost);
    double lost_area_fraction;  ///< of what Cocone found
};

/// Open: Cocone with boundary detection [Amenta02, Dey01], walked into oriented 2-manifold pieces
/// with borders. Watertight: Tight Cocone [Dey03], split by index into a closed, oriented
/// 2-manifold with positive volume; Robust Cocone [Dey06] does so over the outer points of noise
/// only. Pieces of open surfaces face the sensors (`cloud.sensors`), else the side of the file's
/// normals (`cloud.given_normals`) if they agree, else outwards. Coplanar clouds give a flat open
/// mesh. Deterministic for any number of threads and any order of the points. Near linear time,
/// about 1.2 kB per point. Throws Error{kDegenerate} for fewer than 3 distinct or for collinear
/// points, and where the points span no surface of the kind that is asked for; with Method::kAuto
/// TooLittleEnclosed where a watertight one would lose most of what was found.
ReconstructResult reconstruct(const PointCloud& cloud, const ReconstructOptions& options = {},
                              const Context& context = {});

/// False for the Cocone family in builds without CGAL (-DPOINTBAKE_CGAL=OFF).
bool is_available(Method method);

/// Throws Error{kInvalidOption} for a method that does not make the surface asked for or that this
/// build lacks; nothing is said about a given surface, which no method makes.
void validate(const ReconstructOptions& options);

/// The implicit method works from oriented normals and areas: as asked for, and for `auto` in
/// builds without a triangulation.
bool needs_normals(const ReconstructOptions& options);

}  // namespace pointbake
