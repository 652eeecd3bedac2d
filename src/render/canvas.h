// What the pictures have in common: the camera, the samples of a pixel, depth, and their average.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/render.h"
#include "pointbake/types.h"

namespace pointbake::render {

/// Samples per pixel in each direction.
inline constexpr int kSuper = 3;

/// Model space to picture: x to the right and y downwards in pixels (pixel (i, j) covers
/// [i, i+1) x [j, j+1)), z towards the viewer in pixels too, 0 at the centre of the box.
struct Camera {
    Vec3d origin, right, up, toward;
    double scale = 1.0;  ///< pixels per unit
    double half_width = 0.0, half_height = 0.0;

    /// The view of view.box, or of the box around `positions`. Throws Error{kInvalidOption} if the
    /// view's direction or size is no direction or size.
    Camera(const View& view, std::span<const Vec3d> positions);
    Vec3d project(Vec3d p) const {
        const Vec3d q = p - origin;
        return {half_width + scale * dot(q, right), half_height - scale * dot(q, up),
                scale * dot(q, toward)};
    }
    /// A direction or a step, in the picture's axes.
    Vec3d turn(Vec3d d) const { return {dot(d, right), -dot(d, up), dot(d, toward)}; }
};

/// The samples of a band of pixel rows. The nearest surface wins; ties go to the lower id.
struct Band {
    int first_row = 0, num_rows = 0, width = 0;  ///< in pixels
    std::vector<float> depth;                    ///< larger is nearer
    std::vector<Index> id;                       ///< kInvalidIndex = background
    std::vector<Vec3f> color;                    ///< linear light, where there is an id

    int sample_rows() const { return num_rows * kSuper; }
    int sample_columns() const { return width * kSuper; }
    std::size_t sample(int row, int column) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(sample_columns()) +
               static_cast<std::size_t>(column);
    }
    /// Place of a sample's centre, in pixels.
    double sample_x(int column) const { return (column + 0.5) / kSuper; }
    double sample_y(int row) const { return first_row + (row + 0.5) / kSuper; }
    void offer(int row, int column, float z, Index candidate) {
        const std::size_t k = sample(row, column);
        if (z > depth[k] || (z == depth[k] && candidate < id[k])) {
            depth[k] = z;
            id[k] = candidate;
        }
    }
    /// Sample rows or columns whose centres lie within [low, high], clipped to the band.
    std::pair<int, int> rows_between(double low, double high) const;
    std::pair<int, int> columns_between(double low, double high) const;
};

/// Draws primitive `id` into a band.
using Rasterizer = std::function<void(Index id, Band& band)>;
/// Colour in linear light of primitive `id` at a place of the picture.
using Shader = std::function<Vec3f(Index id, double x, double y)>;
/// Fills ids and colours of a band from the primitives that touch it, in ascending order.
using BandPainter = std::function<void(std::span<const Index> primitives, Band& band)>;

/// Vertical range of a primitive in pixels.
struct RowRange {
    float low = 0.0F, high = 0.0F;
};

/// Draws all primitives and averages the samples of each pixel in linear light. Deterministic for
/// any number of threads.
Image draw(const View& view, std::span<const RowRange> primitives, const BandPainter& paint,
           const Context& context);

/// The painter of opaque surfaces: the nearest primitive of each sample gives its colour.
BandPainter opaque(Rasterizer rasterize, Shader shade);

/// The background, 8-bit sRGB.
inline constexpr std::uint8_t kBackground[3] = {244, 244, 241};

}  // namespace pointbake::render
