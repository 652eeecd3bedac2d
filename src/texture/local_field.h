// The splatted function around one triangle: its own splats and, unfolded across edges into its
// plane, those of the neighbours. Both sides of an edge see the same splats at the same places: the
// cure for seams.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "texture/footprints.h"

namespace pointbake {

/// A splat in the frame of the triangle that looks at it.
struct LocalSplat {
    Vec2f center;
    float vxx, vxy, vyy;
    Index item;  ///< into Footprints::items
};

/// Everything that does not change while textures are made (but for prints.widen, which is found
/// on the way).
struct SplatScene {
    const Mesh& mesh;
    const Shell& shell;
    const std::vector<std::array<Index, 3>>& neighbors;
    const Footprints& prints;
    const Kernel& kernel;
};

/// Weighted sum of splat values: value = sum / weight.
struct SplatSum {
    Vec3f sum{};
    float weight = 0.0F;
};

/// Scratch for one triangle after the other; one per thread.
class LocalField {
 public:
    explicit LocalField(const SplatScene& scene) : scene_(scene) {}

    /// Gathers the splats that, with kernels `widen` times as wide, reach the triangle grown by
    /// `border` (cloud units).
    void gather(Index triangle, double border, float widen = 1.0F);
    /// Whether kernels so widened reach x.
    bool is_covered(Vec2f x) const;

    std::span<const LocalSplat> splats() const { return splats_; }
    const Kernel& kernel() const { return scene_.kernel; }

    /// Calls visit(item, weight) for the splats that reach x in the triangle's plane.
    template <class Visit>
    void for_each_weight(Vec2f x, Visit&& visit) const {
        const std::size_t cell = cell_at(x);
        for (Index k = cell_begin_[cell]; k < cell_begin_[cell + 1]; ++k) {
            const Index i = cell_items_[k];
            const float q = squared_radius(x, i);
            if (q < scene_.kernel.cut2) visit(splats_[i].item, scene_.kernel(q));
        }
    }

    /// The splatted function at x in the triangle's plane; `values` per item. Where no splat
    /// reaches, the kernels are widened until one does; weight 0 = there are no splats at all.
    SplatSum evaluate(Vec2f x, std::span<const Vec3f> values) const;

 private:
    static constexpr std::size_t kHome =
        3;  ///< `root` of the triangle that everything is unfolded around
    struct Unfolded {
        Index triangle;
        std::size_t root;     ///< edge of the home triangle that the way to this one leaves through
        double c, s, tx, ty;  ///< x' = c x - s y + tx, y' = s x + c y + ty
        Vec2d place(Vec2d x) const { return {c * x.x - s * x.y + tx, s * x.x + c * x.y + ty}; }
    };
    struct RootEdge {
        Vec2d start, along, outward;  ///< unit vectors; outward of the home triangle
        double length = 0.0;
    };
    // Triangles unfolded so far: a small open-addressing set.
    class Seen {
     public:
        bool contains(Index triangle) const;
        void insert(Index triangle);  ///< must not be there yet
        void clear();

     private:
        std::size_t slot_of(Index triangle) const;
        static constexpr std::size_t kSlots = 2048;  ///< several times the most that is unfolded
        std::vector<Index> slots_ = std::vector<Index>(kSlots, kInvalidIndex);
        std::vector<std::size_t> used_;
    };
    struct Inverse {
        float a, b, c, radius_x, radius_y;
    };
    // Squared distance of a place from a splat, in the splat's standard deviations.
    float squared_radius(Vec2f x, Index splat) const {
        const Inverse& v = inverses_[splat];
        const float dx = x.x - splats_[splat].center.x, dy = x.y - splats_[splat].center.y;
        return v.a * dx * dx + 2.0F * v.b * dx * dy + v.c * dy * dy;
    }
    void unfold(Index triangle, double reach);
    std::optional<Unfolded> unfold_across(const Unfolded& at, std::size_t k, Index next) const;
    bool is_near_root(const Unfolded& u, double reach) const;
    Vec2d nearest_home(Vec2d x) const;
    bool is_beyond(std::size_t edge, Vec2f x) const;
    bool is_placed(const Unfolded& from, Vec2f own, Vec2f here) const;
    void add_splats(const Unfolded& from, double border);
    void build_bins();
    std::size_t cell_at(Vec2f x) const;
    template <class Visit>
    void for_each_wide_weight(Vec2f x, float widen, Visit&& visit) const;
    SplatSum evaluate_wide(Vec2f x, std::span<const Vec3f> values) const;

    SplatScene scene_;
    Index triangle_ = kInvalidIndex;
    float widen_ = 1.0F;
    std::array<RootEdge, 3> roots_{};
    std::vector<Unfolded> queue_;
    Seen seen_;
    std::vector<LocalSplat> splats_;
    std::vector<Inverse> inverses_;

    // Splats by cell of a grid over the triangle's box; a splat, widened, is in every cell that it
    // reaches.
    Vec2f grid_origin_{};
    float cells_per_unit_ = 0.0F;
    int grid_width_ = 0, grid_height_ = 0;
    std::vector<Index> cell_begin_, cell_items_;
};

}  // namespace pointbake
