// Triangles: shaded by a light beside the camera, with wires, or textured.
#include <algorithm>
#include <cmath>

#include "core/color.h"
#include "core/message.h"
#include "core/parallel.h"
#include "render/canvas.h"

namespace pointbake {
namespace {

using render::Band;
using render::Camera;
using render::RowRange;

// Clay and wire, in linear light.
constexpr Vec3f kClay{0.62F, 0.60F, 0.56F};
constexpr Vec3f kWire{0.012F, 0.020F, 0.045F};
constexpr double kWireWidth = 0.9;  // pixels
constexpr double kAmbient = 0.30;   // share of the light that comes from everywhere

// A triangle on the picture: corners in pixels, and its doubled signed area.
struct Face {
    std::array<Vec3d, 3> corners;
    double area2 = 0.0;
};

struct Projected {
    std::vector<Vec3d> positions;
    std::vector<RowRange> ranges;
    std::span<const Triangle> triangles;

    Projected(const Mesh& mesh, const Camera& camera, const Context& context)
        : positions(mesh.positions.size()),
          ranges(mesh.triangles.size()),
          triangles(mesh.triangles) {
        constexpr std::size_t kGrain = 16384;
        parallel_for(context, positions.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v)
                positions[v] = camera.project(mesh.positions[v]);
        });
        parallel_for(context, ranges.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t t = begin; t < end; ++t) {
                const Face f = face(static_cast<Index>(t));
                const auto [low, high] =
                    std::minmax({f.corners[0].y, f.corners[1].y, f.corners[2].y});
                ranges[t] = {static_cast<float>(low), static_cast<float>(high)};
            }
        });
    }
    Face face(Index t) const {
        const Triangle& c = triangles[t];
        Face f{{positions[c[0]], positions[c[1]], positions[c[2]]}, 0.0};
        const Vec3d u = f.corners[1] - f.corners[0], v = f.corners[2] - f.corners[0];
        f.area2 = u.x * v.y - u.y * v.x;
        return f;
    }
};

// Barycentric coordinates of a place of the picture.
Vec3d barycentric(const Face& f, double x, double y) {
    const auto part = [&](const Vec3d& a, const Vec3d& b) {
        return ((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)) / f.area2;
    };
    return {part(f.corners[1], f.corners[2]), part(f.corners[2], f.corners[0]),
            part(f.corners[0], f.corners[1])};
}

void rasterize_face(const Face& f, Index id, Band& band) {
    if (f.area2 == 0.0) return;
    const auto [low, high] = std::minmax({f.corners[0].y, f.corners[1].y, f.corners[2].y});
    const auto [first, last] = band.rows_between(low, high);
    for (int row = first; row < last; ++row) {
        // The row's span is the intersection of the three edges' half planes.
        const double y = band.sample_y(row);
        double left = HUGE_VAL, right = -HUGE_VAL;
        for (std::size_t k = 0; k < 3; ++k) {
            // Each edge from its lower end, whichever triangle asks: neighbours leave no gap.
            const Vec3d *a = &f.corners[k], *b = &f.corners[(k + 1) % 3];
            if (a->y > b->y || (a->y == b->y && a->x > b->x)) std::swap(a, b);
            if (b->y < y || a->y > y) continue;
            const double t = a->y == b->y ? 0.0 : (y - a->y) / (b->y - a->y);
            const double x = a->x + (b->x - a->x) * t;
            left = std::min(left, x);
            right = std::max(right, a->y == b->y ? b->x : x);
        }
        if (left > right) continue;
        const auto [begin, end] = band.columns_between(left, right);
        if (begin >= end) continue;
        const Vec3d w = barycentric(f, band.sample_x(begin), y);
        const Vec3d w1 = barycentric(f, band.sample_x(begin) + 1.0 / render::kSuper, y);
        const Vec3d depths{f.corners[0].z, f.corners[1].z, f.corners[2].z};
        const double z = dot(w, depths), step = dot(w1 - w, depths);
        for (int column = begin; column < end; ++column)
            band.offer(row, column, static_cast<float>(z + step * (column - begin)), id);
    }
}

// Light beside and above the camera, the same for both sides of a face.
float light_on(Vec3d a, Vec3d b, Vec3d c, const Camera& camera) {
    Vec3d n = normalized(cross(b - a, c - a));
    if (dot(n, camera.toward) < 0.0) n = -n;
    const Vec3d light = normalized(camera.toward + camera.right * -0.35 + camera.up * 0.55);
    return static_cast<float>(kAmbient + (1.0 - kAmbient) * std::max(0.0, dot(n, light)));
}

// How much of a sample is wire: 1 on the edge, a ramp of one pixel at the sides.
double wire_share(const Face& f, const Vec3d& w) {
    double distance = HUGE_VAL;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d edge = f.corners[(k + 2) % 3] - f.corners[(k + 1) % 3];
        const double base = std::sqrt(edge.x * edge.x + edge.y * edge.y);
        if (base > 0.0) distance = std::min(distance, w[k] * std::abs(f.area2) / base);
    }
    return std::clamp(0.5 * kWireWidth + 0.5 - distance, 0.0, 1.0);
}

// Textures in linear light, ready to be sampled.
struct LinearImage {
    const Image& image;
    const std::array<float, 256>& table;

    Vec3f texel(int x, int y) const {
        const std::size_t at = static_cast<std::size_t>(image.num_channels) * image.texel(x, y);
        const std::size_t step = image.num_channels >= 3 ? 1 : 0;  // grey: the same thrice
        return {table[image.pixels[at]], table[image.pixels[at + step]],
                table[image.pixels[at + 2 * step]]};
    }
    // Bilinear; (0, 0) is the upper left corner.
    Vec3f at(double u, double v) const {
        const double x = u * image.width - 0.5, y = v * image.height - 0.5;
        const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
        const auto s = static_cast<float>(x - i), t = static_cast<float>(y - j);
        return (texel(i, j) * (1.0F - s) + texel(i + 1, j) * s) * (1.0F - t) +
               (texel(i, j + 1) * (1.0F - s) + texel(i + 1, j + 1) * s) * t;
    }
};

std::array<float, 256> linear_table() {
    std::array<float, 256> table{};
    for (std::size_t k = 0; k < 256; ++k)
        table[k] = srgb_to_linear(static_cast<std::uint16_t>(257 * k));
    return table;
}

// The colour of a textured model at a place of one of its triangles, in linear light.
class Surface {
 public:
    explicit Surface(const TexturedMesh& model) : model_(model), table_(linear_table()) {
        for (const Material& m : model.materials)
            if (m.color_image >= static_cast<int>(model.images.size()))
                fail(ErrorCode::kInvalidInput, "material '{}' asks for image {} of {}", m.name,
                     m.color_image, model.images.size());
        for (const Index m : model.triangle_materials)
            if (m >= model.materials.size())
                fail(ErrorCode::kInvalidInput, "a triangle asks for material {} of {}", m,
                     model.materials.size());
    }
    Vec3f color(Index t, const Vec3d& w) const {
        const Mesh& mesh = model_.mesh;
        const Material material =
            model_.materials.empty()
                ? Material{}
                : model_
                      .materials[model_.triangle_materials.empty() ? 0
                                                                   : model_.triangle_materials[t]];
        const Vec3f base{static_cast<float>(material.base_color[0]),
                         static_cast<float>(material.base_color[1]),
                         static_cast<float>(material.base_color[2])};
        Vec3f c{1.0F, 1.0F, 1.0F};
        if (material.color_image >= 0 && !mesh.uvs.empty()) {
            Vec2d uv;
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec2f corner = mesh.uvs[t][k];
                uv = uv + Vec2d{corner.x, corner.y} * w[k];
            }
            const Image& image = model_.images[static_cast<std::size_t>(material.color_image)];
            c = LinearImage{image, table_}.at(uv.x, uv.y);
        } else if (!mesh.colors.empty()) {
            c = {};
            for (std::size_t k = 0; k < 3; ++k)
                c += to_linear(mesh.colors[mesh.triangles[t][k]]) * static_cast<float>(w[k]);
        }
        return {c.x * base.x, c.y * base.y, c.z * base.z};
    }
    bool has_color() const { return !model_.mesh.colors.empty() || !model_.images.empty(); }

 private:
    const TexturedMesh& model_;
    std::array<float, 256> table_;
};

}  // namespace

Image render_textured(const TexturedMesh& model, const View& view, const Context& context) {
    const Camera camera(view, model.mesh.positions);
    const Projected projected(model.mesh, camera, context);
    const Surface surface(model);
    return render::draw(
        view, projected.ranges,
        render::opaque([&](Index t, Band& band) { rasterize_face(projected.face(t), t, band); },
                       [&](Index t, double x, double y) {
                           return surface.color(t, barycentric(projected.face(t), x, y));
                       }),
        context);
}

Image render_mesh(const Mesh& mesh, bool wires, const View& view, const Context& context) {
    const Camera camera(view, mesh.positions);
    const Projected projected(mesh, camera, context);
    std::vector<float> light(mesh.triangles.size());
    for (std::size_t t = 0; t < light.size(); ++t) {
        const Triangle& c = mesh.triangles[t];
        light[t] =
            light_on(mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]], camera);
    }
    return render::draw(
        view, projected.ranges,
        render::opaque([&](Index t, Band& band) { rasterize_face(projected.face(t), t, band); },
                       [&](Index t, double x, double y) {
                           const Vec3f clay = kClay * light[t];
                           if (!wires) return clay;
                           const Face f = projected.face(t);
                           const auto share =
                               static_cast<float>(wire_share(f, barycentric(f, x, y)));
                           return clay * (1.0F - share) + kWire * share;
                       }),
        context);
}

}  // namespace pointbake
