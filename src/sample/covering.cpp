// Branch and bound over the triangles near seams: the distance to the nearest sample changes by at
// most as much as one moves, so a piece of a triangle is covered if its centre is, by its radius.
#include "sample/covering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "core/adjacency.h"
#include "core/hash.h"
#include "core/kdtree.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

// All in units of the spacing. A tilted square grid covers within sqrt(3)/2 = 0.8660, and rounding
// moves its samples by 0.001: pieces farther away than kCovered are gaps, and pieces smaller than
// kSmallest are not divided. Together they stay below 0.87.
constexpr double kCovered = 0.868;
constexpr double kSmallest = 0.0015;
// Farther than this from all seams, a grid's samples are all there.
constexpr double kSeamReach = 2.0;
constexpr double kSeamStep = 0.5;  // between the points that stand for a seam

// Where the surface turns by more (cosine of 20 degrees) it is no longer nearly a plane.
constexpr double kCreaseCosine = 0.94;

constexpr std::size_t kGrain = 64;  // triangles per chunk

/// True if the grid does not simply go on from triangle s to its neighbour t.
bool is_seam(const Mesh& mesh, Index s, Index t) {
    if (t == kInvalidIndex) return true;
    const Vec3d a = normalized(TriangleFrame(mesh, s).normal());
    const Vec3d b = normalized(TriangleFrame(mesh, t).normal());
    return dominant_axis(a) != dominant_axis(b) || !(dot(a, b) > kCreaseCosine);
}

/// Points along all seams, at most `step` apart.
std::vector<Vec3d> seam_points(const Mesh& mesh, double step) {
    const auto neighbors = triangle_neighbors(mesh.triangles);
    std::vector<Vec3d> points;
    for (Index t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const Index other = neighbors[t][k];
            if (other < t || !is_seam(mesh, t, other)) continue;
            const Vec3d a = mesh.positions[mesh.triangles[t][k]];
            const Vec3d ab = mesh.positions[mesh.triangles[t][(k + 1) % 3]] - a;
            const double count = std::ceil(length(ab) / step) + 1.0;
            for (double i = 0.5; i < count; i += 1.0) points.push_back(a + ab * (i / count));
        }
    return points;
}

/// A part of a triangle, by its corners (u, v).
struct Piece {
    Index triangle = kInvalidIndex;
    std::array<Vec2d, 3> corners;

    Vec2d center() const { return (corners[0] + corners[1] + corners[2]) / 3.0; }
    /// Cut across the longest side: slivers become pieces that are no slivers.
    std::array<Piece, 2> halves(const TriangleFrame& frame) const {
        std::size_t longest = 0;
        double largest = -1.0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec2d side = corners[(k + 1) % 3] - corners[k];
            const double squared = squared_length(frame.ab * side.x + frame.ac * side.y);
            if (squared > largest) {
                largest = squared;
                longest = k;
            }
        }
        const Vec2d a = corners[longest], b = corners[(longest + 1) % 3],
                    c = corners[(longest + 2) % 3];
        const Vec2d middle = (a + b) * 0.5;
        return {Piece{triangle, {a, middle, c}}, Piece{triangle, {middle, b, c}}};
    }
};

struct Disc {
    Vec3d center;
    double radius = 0.0;
};

/// The smallest disc around the piece's centre that holds it.
Disc disc_around(const TriangleFrame& frame, const Piece& piece) {
    const Vec2d middle = piece.center();
    Disc disc{frame.at(middle.x, middle.y), 0.0};
    for (const Vec2d q : piece.corners)
        disc.radius = std::max(disc.radius, length(frame.at(q.x, q.y) - disc.center));
    return disc;
}

double distance(const KdTree& tree, Vec3d p) {
    Neighbor nearest;
    const auto found = tree.nearest(p, std::span(&nearest, 1));
    return found.empty() ? HUGE_VAL : std::sqrt(nearest.squared_distance);
}

/// Samples added so far, in cells as large as the distance that is asked for.
class AddedSamples {
 public:
    explicit AddedSamples(double reach) : reach_(reach) {}

    struct Hit {
        Index index = kInvalidIndex;
        double distance = HUGE_VAL;
    };
    /// The nearest one within reach.
    Hit nearest(Vec3d p) const {
        Hit best;
        const auto [x, y, z] = cell_of(p);
        for (std::int64_t i = x - 1; i <= x + 1; ++i)
            for (std::int64_t j = y - 1; j <= y + 1; ++j)
                for (std::int64_t k = z - 1; k <= z + 1; ++k) {
                    const auto cell = cells_.find(key({i, j, k}));
                    if (cell == cells_.end()) continue;
                    for (const Index index : cell->second) {
                        const double d = length(positions_[index] - p);
                        if (d < best.distance) best = {index, d};
                    }
                }
        return best;
    }
    void add(Vec3d p) {
        cells_[key(cell_of(p))].push_back(static_cast<Index>(positions_.size()));
        positions_.push_back(p);
    }

 private:
    using Cell = std::array<std::int64_t, 3>;
    Cell cell_of(Vec3d p) const {
        Cell cell;
        for (std::size_t k = 0; k < 3; ++k)
            cell[k] = static_cast<std::int64_t>(std::floor(p[k] / reach_));
        return cell;
    }
    /// Two cells with one key only cost time: distances decide.
    static std::uint64_t key(Cell c) {
        return hash64(hash64(static_cast<std::uint64_t>(c[0]), static_cast<std::uint64_t>(c[1])),
                      static_cast<std::uint64_t>(c[2]));
    }

    double reach_;
    std::vector<Vec3d> positions_;
    std::unordered_map<std::uint64_t, std::vector<Index>> cells_;
};

/// Finds gaps in parallel against the grid's samples, then fills them one by one.
class GapFiller {
 public:
    GapFiller(const Mesh& mesh, RayGridSamples& grid)
        : mesh_(mesh),
          grid_(grid),
          num_regular_(grid.samples.size()),
          positions_(sample_positions(mesh, grid)),
          samples_(positions_),
          seam_positions_(seam_points(mesh, kSeamStep * grid.spacing)),
          seams_(seam_positions_),
          added_(grid.spacing) {}

    void fill(const Context& context) {
        const std::size_t num_triangles = mesh_.triangles.size();
        std::vector<std::vector<Piece>> gaps((num_triangles + kGrain - 1) / kGrain);
        parallel_for(context, num_triangles, kGrain, [&](std::size_t begin, std::size_t end) {
            for (auto t = static_cast<Index>(begin); t < end; ++t)
                if (squared_length(TriangleFrame(mesh_, t).normal()) > 0.0)
                    find_gaps(whole(t), gaps[begin / kGrain]);
        });
        for (const auto& part : gaps) {
            check_cancelled(context);
            for (const Piece& piece : part) fill_gap(piece);
        }
    }

 private:
    static std::vector<Vec3d> sample_positions(const Mesh& mesh, const RayGridSamples& grid) {
        std::vector<Vec3d> positions;
        positions.reserve(grid.samples.size());
        for (const SurfaceSample& s : grid.samples) positions.push_back(position(mesh, s));
        return positions;
    }

    static Piece whole(Index triangle) {
        return {triangle, {Vec2d{0.0, 0.0}, Vec2d{1.0, 0.0}, Vec2d{0.0, 1.0}}};
    }

    /// Appends the pieces that are not covered by the grid's samples.
    void find_gaps(const Piece& piece, std::vector<Piece>& gaps) const {
        const TriangleFrame frame(mesh_, piece.triangle);
        const Disc disc = disc_around(frame, piece);
        const double h = grid_.spacing;
        if (distance(seams_, disc.center) > kSeamReach * h + disc.radius) return;
        const double d = distance(samples_, disc.center);
        if (d + disc.radius <= kCovered * h) return;
        if (d > kCovered * h && disc.radius <= h) {
            gaps.push_back(piece);
        } else if (disc.radius > kSmallest * h) {
            for (const Piece& half : piece.halves(frame)) find_gaps(half, gaps);
        }
    }

    /// Adds a sample at the centre of each part that no sample covers, the added ones included.
    void fill_gap(const Piece& piece) {
        const TriangleFrame frame(mesh_, piece.triangle);
        const Disc disc = disc_around(frame, piece);
        const double h = grid_.spacing;
        Neighbor regular{kInvalidIndex, HUGE_VAL};
        samples_.nearest(disc.center, std::span(&regular, 1));
        const AddedSamples::Hit extra = added_.nearest(disc.center);
        double d = std::min(std::sqrt(regular.squared_distance), extra.distance);
        if (d > kCovered * h) {
            const bool is_extra_nearer = extra.distance < std::sqrt(regular.squared_distance);
            add_sample(piece, disc.center,
                       is_extra_nearer ? num_regular_ + extra.index : regular.index);
            d = 0.0;
        }
        if (d + disc.radius <= kCovered * h || disc.radius <= kSmallest * h) return;
        for (const Piece& half : piece.halves(frame)) fill_gap(half);
    }

    void add_sample(const Piece& piece, Vec3d p, std::size_t nearest) {
        float area = 0.0F;
        if (nearest < grid_.samples.size()) {
            area = 0.5F * grid_.samples[nearest].area;
            grid_.samples[nearest].area -= area;
        }
        const Vec2d middle = piece.center();
        grid_.samples.push_back({piece.triangle, area, middle.x, middle.y});
        added_.add(p);
    }

    const Mesh& mesh_;
    RayGridSamples& grid_;
    std::size_t num_regular_;
    std::vector<Vec3d> positions_;
    KdTree samples_;
    std::vector<Vec3d> seam_positions_;
    KdTree seams_;
    AddedSamples added_;
};

}  // namespace

void cover_gaps_in_place(RayGridSamples& grid, const Mesh& mesh, const Context& context) {
    GapFiller(mesh, grid).fill(context);
}

}  // namespace pointbake
