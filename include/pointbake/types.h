// The values that stages hand to each other. Plain structs of parallel arrays: an empty array means
// "not present", every non-empty one has one entry per point (vertex, triangle).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pointbake/options.h"
#include "pointbake/vec.h"

namespace pointbake {

using Index = std::uint32_t;
inline constexpr Index kInvalidIndex = ~Index{0};
using Triangle = std::array<Index, 3>;

/// sRGB-coded colour, 16 bit per channel; an 8-bit value v is stored as 257 v.
struct Rgb16 {
    std::uint16_t r = 0, g = 0, b = 0;
    friend constexpr bool operator==(const Rgb16&, const Rgb16&) = default;
};

/// Two tangent axes of an elliptical surfel. Their lengths are the Gaussian's standard deviations,
/// in cloud units.
struct TangentAxes {
    Vec3f u, v;
};

/// Why an input row is not a point of the cloud (any more), or merged into another one.
enum class DropReason : std::uint8_t {
    kKept = 0,
    kMerged = 1,      ///< same coordinates as another row, which stands for it: counts as kept
    kNonFinite = 2,   ///< a coordinate is NaN or infinite
    kOffSurface = 3,  ///< the reconstructed surface leaves it out, farther than the geometry bound
    kOutlier = 4,     ///< cleaning: off the surface, by the distances to its neighbours
    kFloating = 5,    ///< cleaning: of a small piece that floats beside the model
    kCropped = 6,     ///< outside of --crop
    kSubsampled = 7,  ///< another point that is kept lies nearer than --subsample
    kUnreadable = 8,  ///< the row of a text file holds other things than numbers
    kNoReturn = 9,    ///< the scanner looked there, but nothing came back
    kNoSurfel = 10,   ///< a Gaussian splat too faint, too large or too thin to be of a surface
    kWithheld = 11,   ///< the file itself marks the point as not to be used
};
inline constexpr int kNumDropReasons = 12;
std::string_view to_string(DropReason reason);

/// An input row that is not kept.
struct DroppedPoint {
    std::uint64_t row = 0;
    Vec3d position;
    DropReason reason = DropReason::kKept;
};

enum class ChannelKind : std::uint8_t { kScalar, kCategory, kVector };

/// Which axis of the coordinates points up.
enum class UpAxis { kAuto, kX, kY, kZ, kMinusY };
template <>
struct EnumWords<UpAxis> {
    static constexpr std::string_view words[] = {"auto", "x", "y", "z", "-y"};
};

/// A coordinate reference system.
struct Crs {
    std::string name{};          ///< "NAD83 / UTM zone 15N"; empty = none is known
    int epsg = 0;                ///< its EPSG code; 0 = not known
    std::string vertical{};      ///< name of the system of the heights; empty = not told
    bool is_geographic = false;  ///< x and y are angles
    /// Its horizontal part as ESRI's WKT, which .prj files hold; empty = not known.
    std::string wkt{};
    friend bool operator==(const Crs&, const Crs&) = default;
};

/// Where coordinates stand in space, as far as their file tells.
struct Frame {
    UpAxis up = UpAxis::kAuto;     ///< kAuto: not told; taken for y
    double metres_per_unit = 0.0;  ///< 0: not told; taken for 1
    std::string unit{};            ///< of x and y, "US survey foot"; empty = not told
    std::string height_unit{};     ///< of the heights, where the file tells it apart
    Crs crs{};
    friend bool operator==(const Frame&, const Frame&) = default;
};

/// Any other attribute of the points: intensity, classification, confidence, ...
struct Channel {
    std::string name;
    std::string unit;
    ChannelKind kind = ChannelKind::kScalar;
    Index num_components = 1;
    std::vector<float> data;  ///< size() * num_components values
};

/// A point cloud, as loaded in Morton order. All lengths are in the file's own unit.
struct PointCloud {
    std::vector<Vec3d> positions;  ///< in double; as read, unless denoise() moved them
    std::vector<Vec3d> measured;   ///< as read, if denoise() moved them
    std::vector<Rgb16> colors;     ///< sRGB-coded
    std::vector<Vec3f> normals;    ///< unit length; zero = unknown
    std::vector<std::uint8_t>
        given_normals;  ///< 1 = the file's normal, whose sign may be believed; empty = none is
    std::vector<float> radii;       ///< surfel radius as the file gives it, or equivalent spacing
    std::vector<float> areas;       ///< area that a point stands for
    std::vector<TangentAxes> axes;  ///< only for elliptical surfels
    std::vector<Vec3f>
        sensors;  ///< direction from the point to the sensor that saw it; zero = unknown
    std::vector<float> weights;       ///< confidence or opacity, (0, 1]
    std::vector<std::uint64_t> rows;  ///< input row of each point
    std::vector<Channel> channels;

    Frame frame;
    bool are_splats = false;  ///< Gaussian splats: axes and weights are theirs

    double noise = 0.0;  ///< across the surface, in local spacings, if it was measured

    std::uint64_t num_rows = 0;         ///< rows in the input
    std::vector<DroppedPoint> dropped;  ///< rows that are no points, by row
    std::vector<std::pair<std::uint64_t, std::uint64_t>>
        merged;  ///< (row, row that stands for it), by row

    std::size_t size() const { return positions.size(); }
};

/// 8-bit image, rows from top to bottom, channels interleaved.
struct Image {
    int width = 0, height = 0, num_channels = 3;
    std::vector<std::uint8_t> pixels;
    // As a page of a model that was made:
    bool repeats = false;   ///< beyond 0..1 it begins again
    bool has_mips = false;  ///< what lies side by side may be mixed: viewers may use mip levels
    /// A JPEG or WebP file that holds just these pixels, and is written as it is; empty = none:
    /// written as PNG.
    std::vector<std::byte> file{};

    std::size_t num_texels() const {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
    /// Place of the texel in column x and row y, which may lie beyond the image.
    std::size_t texel(int x, int y) const {
        return static_cast<std::size_t>(inside(y, height)) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(inside(x, width));
    }

 private:
    int inside(int i, int size) const {
        if (repeats) return ((i % size) + size) % size;
        return i < 0 ? 0 : (i < size ? i : size - 1);
    }
};

/// Triangles over shared vertices, counter-clockwise seen from outside.
struct Mesh {
    std::vector<Vec3d> positions;
    std::vector<Triangle> triangles;
    std::vector<Vec3f> normals;  ///< per vertex, unit length
    std::vector<Rgb16> colors;   ///< per vertex, sRGB-coded
    std::vector<std::array<Vec2f, 3>>
        uvs;  ///< per triangle and corner; (0,0) = upper left corner of the image (glTF)
};

/// A dense mesh over the cloud's points, as reconstruct hands it on.
struct DenseMesh {
    Mesh mesh;
    std::vector<Index> vertex_points;  ///< point under each vertex; empty for a mesh that does not
                                       ///< come from the cloud
};

struct Material {
    std::string name = "material";
    std::array<double, 3> base_color{1.0, 1.0, 1.0};  ///< linear light
    int color_image = -1;                             ///< index into images, -1 = none
    bool is_double_sided = false;  ///< seen from behind, too: for surfaces with a border
    int normal_image = -1;         ///< tangent-space map, index into images, -1 = none
};

/// A mesh with its textures: what sample reads and what convert writes.
struct TexturedMesh {
    Mesh mesh;
    std::vector<Vec3f>
        corner_tangents;  ///< per triangle: direction of +u (for normal maps); empty = none
    std::vector<std::int8_t> tangent_signs;  ///< per triangle: handedness, +1 or -1
    std::vector<Index> triangle_materials;   ///< per triangle; empty = all 0
    std::vector<Material> materials;
    std::vector<Image> images;
    Frame frame;
};

}  // namespace pointbake
