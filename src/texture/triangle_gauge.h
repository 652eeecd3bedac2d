// One triangle's texels at any layout, and how far they are from the splatted function.
#pragma once

#include <vector>

#include "texture/patch_texels.h"

namespace pointbake {

/// Looks at one triangle after the other; one per thread. What a gauge makes is what is measured
/// and what is written.
class TriangleGauge {
 public:
    TriangleGauge(const SplatScene& scene, const PointCloud& cloud, MapKind kind,
                  std::span<const Vec3f> values, bool paper = false)
        : scene_(scene),
          cloud_(cloud),
          kind_(kind),
          values_(values),
          is_paper_(paper),
          field_(scene) {}

    /// Gathers the triangle's splats.
    void look_at(Index triangle);
    /// Chooses the places where errors are measured: the triangle's points and its border.
    void place_probes();

    PatchTexels texels(const PatchLayout& layout) const;
    /// RMS over the probes against the splatted function, in 8-bit steps (--paper: eq. (1)).
    float error(const PatchTexels& texels) const;
    /// Finest pitch that the triangle's points support, cloud units: [Wicke05] eq. (2).
    double min_pitch() const;

 private:
    struct Probe {
        Vec2f place;
        Vec3f wanted;  // steps
        float weight;
    };
    double mean_spacing() const;
    TexelFilter filter(double pitch) const;
    void add_probe(Vec2f place, float weight);
    void add_border_probes();
    float rms_error(const PatchTexels& texels) const;
    float paper_error(const PatchTexels& texels) const;

    SplatScene scene_;
    const PointCloud& cloud_;
    MapKind kind_;
    std::span<const Vec3f> values_;
    bool is_paper_;
    LocalField field_;
    Index triangle_ = kInvalidIndex;
    double spacing_ = 0.0;
    std::vector<Probe> probes_;
};

}  // namespace pointbake
