// One triangle's texels at any layout, and how far they are from the splatted function.
#pragma once

#include <functional>
#include <vector>

#include "texture/patch_texels.h"

namespace pointbake {

/// [Wicke05] eq. (2) on a square grid: (d / s)^2 = 8.
inline constexpr double kTexelsPerPoint = 8.0;
/// RMS error at which 8-bit rounding is nearly all that is left: rounding alone is 0.29.
inline constexpr float kNothingToGain = 0.35F;

/// Looks at one triangle after the other; one per thread.
class TriangleGauge {
 public:
    TriangleGauge(const SplatScene& scene, const PointCloud& cloud, const MapValues& map,
                  bool is_paper = false)
        : scene_(scene), cloud_(cloud), map_(map), is_paper_(is_paper), field_(scene) {}

    void look_at(Index triangle);
    /// Gathers the splats that reach the triangle grown by `border` (cloud units), and where none
    /// reaches its border those that lie nearest: texels() and add_border_probes() need them.
    void gather(double border = 0.0);
    /// How much wider kernels had to be for that.
    float widen() const { return widen_; }
    /// Errors are measured at the triangle's points. Without, no error is known.
    void place_probes();
    /// And at its border, where the neighbour's patch takes over and the points say nothing.
    void add_border_probes();
    /// Places at the border where errors can be measured; --paper has none.
    std::size_t num_border_places() const { return border_.size(); }
    /// Points that are looked at, and the area that they stand for.
    std::size_t num_probes() const { return probes_.size(); }
    double probed_area() const;

    /// The triangle's need set, or some texels around it.
    PatchTexels texels(const PatchLayout& layout) const;
    PatchTexels texels(const PatchLayout& layout, NeedSet need) const;
    /// RMS over the probes against the splatted function, in 8-bit steps (--paper: eq. (1)), of
    /// what `read` finds at places in the triangle's plane.
    float error(const std::function<Vec3f(Vec2f)>& read) const;
    float error(const PatchTexels& texels) const;
    /// Finest pitch that the triangle's points support, cloud units: [Wicke05] eq. (2).
    double min_pitch() const { return min_pitch_; }
    /// Of the points around.
    double spacing() const { return spacing_; }

 private:
    struct Probe {
        Vec2f place;
        Vec3f wanted;  // steps
        float weight;
    };
    void place_border();
    bool is_border_covered() const;
    double mean_spacing() const;
    TexelFilter filter(double pitch) const;
    double find_min_pitch() const;

    SplatScene scene_;
    const PointCloud& cloud_;
    MapValues map_;
    bool is_paper_;
    LocalField field_;
    Index triangle_ = kInvalidIndex;
    double spacing_ = 0.0, min_pitch_ = 0.0;
    float widen_ = 1.0F;
    std::vector<Vec2f> border_;  // places along the three edges, about a spacing apart
    std::vector<Probe> probes_;
};

}  // namespace pointbake
