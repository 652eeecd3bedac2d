#include "pointbake/render.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/color.h"
#include "core/hash.h"
#include "pointbake/error.h"
#include "render/canvas.h"
#include "support/shapes.h"

namespace pointbake {
namespace {

const View kFront{.direction = {0.0, 0.0, 1.0}, .width = 256, .height = 256};

std::array<int, 3> pixel(const Image& image, int x, int y) {
    const auto at = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                         static_cast<std::size_t>(x));
    return {image.pixels[at], image.pixels[at + 1], image.pixels[at + 2]};
}
const std::array<int, 3> kBackground{render::kBackground[0], render::kBackground[1],
                                     render::kBackground[2]};

std::size_t num_drawn(const Image& image) {
    std::size_t drawn = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) drawn += pixel(image, x, y) != kBackground;
    return drawn;
}

// The unit square in the plane z = 0 with an image on it, upper left corner first.
TexturedMesh textured_quad(Image image, double low = 0.0, double high = 1.0) {
    TexturedMesh model;
    model.mesh.positions = {{0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
    model.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    const auto l = static_cast<float>(low), h = static_cast<float>(high);
    const Vec2f uv[] = {{l, l}, {l, h}, {h, h}, {h, l}};
    model.mesh.uvs = {{uv[0], uv[1], uv[2]}, {uv[0], uv[2], uv[3]}};
    model.materials = {{}};
    model.materials[0].color_image = 0;
    model.images = {std::move(image)};
    return model;
}

Image random_image(int size) {
    Image image{size, size, 3, {}};
    for (std::uint64_t k = 0; k < 3 * image.num_texels(); ++k)
        image.pixels.push_back(static_cast<std::uint8_t>(100 + (hash64(5, k) & 127)));
    return image;
}

// The square fills the picture exactly.
View quad_view(int size) {
    View view = kFront;
    view.zoom = std::numbers::sqrt2;
    view.width = view.height = size;
    return view;
}

TEST(Render, SphereHasTheAreaOfItsOutline) {
    const Mesh sphere = shapes::sphere_mesh(24);
    const Image image = render_mesh(sphere, false, kFront);
    // The box's diagonal, 2 sqrt(3), fills the side. Pixels on the outline count in full: half of
    // them too many.
    const double radius = 256.0 / (2.0 * std::numbers::sqrt3);
    const double outline = 2.0 * std::numbers::pi * radius;
    EXPECT_NEAR(static_cast<double>(num_drawn(image)),
                std::numbers::pi * radius * radius + 0.64 * outline, 0.25 * outline);
    EXPECT_EQ(pixel(image, 0, 0), kBackground);
    EXPECT_EQ(pixel(image, 255, 128), kBackground);
}

TEST(Render, TexturedQuadShowsItsImage) {
    const Image texture = random_image(8);
    const Image image = render_textured(textured_quad(texture), quad_view(512));
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) {
            // At a texel's centre, the pixel's samples lie within 1.3 % of it.
            const auto seen = pixel(image, 64 * x + 32, 64 * y + 32);
            const auto texel = pixel(texture, x, y);
            for (std::size_t k = 0; k < 3; ++k) ASSERT_NEAR(seen[k], texel[k], 4);
        }
}

TEST(Render, NeighboringTrianglesLeaveNoGap) {
    TexturedMesh model;
    model.mesh = shapes::sphere_mesh(24);
    model.mesh.colors.assign(model.mesh.positions.size(), rgb16_from_8bit(90, 20, 160));
    const Image image = render_textured(model);
    const double radius = 0.97 * 512.0 / (2.0 * std::numbers::sqrt3);
    for (int y = 0; y < 512; ++y)
        for (int x = 0; x < 512; ++x) {
            const double dx = x - 255.5, dy = y - 255.5;
            if (dx * dx + dy * dy < radius * radius) {
                ASSERT_EQ(pixel(image, x, y), (std::array<int, 3>{90, 20, 160}));
            }
        }
}

TEST(Render, TexturesAreClampedToTheirEdge) {
    const Image texture = random_image(4);
    // Texture coordinates go from -1 to 2: the middle third is the image.
    const Image image = render_textured(textured_quad(texture, -1.0, 2.0), quad_view(96));
    EXPECT_EQ(pixel(image, 3, 3), pixel(texture, 0, 0));
    EXPECT_EQ(pixel(image, 92, 92), pixel(texture, 3, 3));
    EXPECT_EQ(pixel(image, 92, 3), pixel(texture, 3, 0));
}

TEST(Render, TexturesAreFilteredInLinearLight) {
    Image texture{2, 1, 3, {0, 0, 0, 255, 255, 255}};
    const Image image = render_textured(textured_quad(texture), quad_view(257));
    EXPECT_NEAR(pixel(image, 128, 128)[0], 188, 2);  // half the light
}

TEST(Render, VertexColorsStandInForTexture) {
    TexturedMesh model;
    model.mesh = shapes::cube_mesh();
    model.mesh.colors.assign(8, rgb16_from_8bit(200, 100, 50));
    const Image image = render_textured(model, kFront);
    EXPECT_EQ(pixel(image, 128, 128), (std::array<int, 3>{200, 100, 50}));
}

TEST(Render, NearerTrianglesHideFartherOnes) {
    TexturedMesh model;
    model.mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 1}, {2, 0, 1}, {0, 2, 1}};
    model.mesh.triangles = {{3, 4, 5}, {0, 1, 2}};
    const Rgb16 red = rgb16_from_8bit(255, 0, 0), blue = rgb16_from_8bit(0, 0, 255);
    model.mesh.colors = {blue, blue, blue, red, red, red};
    EXPECT_EQ(pixel(render_textured(model, kFront), 90, 160), (std::array<int, 3>{255, 0, 0}));
    View behind = kFront;
    behind.direction = {0.0, 0.0, -1.0};
    EXPECT_EQ(pixel(render_textured(model, behind), 165, 160), (std::array<int, 3>{0, 0, 255}));
}

TEST(Render, WiresDarkenTheMesh) {
    const Mesh mesh = shapes::torus_mesh(24, 48);
    const Image plain = render_mesh(mesh, false), wired = render_mesh(mesh, true);
    std::size_t darker = 0, brighter = 0;
    for (std::size_t k = 0; k < plain.pixels.size(); ++k) {
        darker += wired.pixels[k] < plain.pixels[k];
        brighter += wired.pixels[k] > plain.pixels[k];
    }
    EXPECT_GT(darker, 3 * num_drawn(plain) / 10);
    EXPECT_EQ(brighter, 0U);
}

TEST(Render, PointsAreDiscsOfTheirRadius) {
    PointCloud cloud;
    cloud.positions = {{-1, 0, 0}, {1, 0, 0}};
    cloud.radii = {0.25F, 0.5F};
    cloud.colors = {rgb16_from_8bit(255, 0, 0), rgb16_from_8bit(0, 255, 0)};
    const Image image = render_points(cloud, kFront);
    std::size_t red = 0, green = 0;
    for (int y = 0; y < 256; ++y)
        for (int x = 0; x < 256; ++x) {
            red += pixel(image, x, y) == std::array<int, 3>{255, 0, 0};
            green += pixel(image, x, y) == std::array<int, 3>{0, 255, 0};
        }
    // 128 pixels per unit; half of each disc lies within the picture, less the mixed pixels of its
    // outline.
    EXPECT_NEAR(static_cast<double>(red), 0.5 * std::numbers::pi * 32 * 32 - 0.64 * 100, 40.0);
    EXPECT_NEAR(static_cast<double>(green), 0.5 * std::numbers::pi * 64 * 64 - 0.64 * 200, 80.0);
}

TEST(Render, PointsWithoutRadiiCoverTheirSurface) {
    PointCloud cloud = shapes::sphere_cloud(4000);
    cloud.colors.assign(cloud.size(), rgb16_from_8bit(10, 20, 200));
    for (const bool has_normals : {true, false}) {
        if (!has_normals) cloud.normals.clear();
        const Image image = render_points(cloud, kFront);
        const double radius = 0.97 * 256.0 / (2.0 * std::numbers::sqrt3);
        std::size_t holes = 0;
        for (int y = 0; y < 256; ++y)
            for (int x = 0; x < 256; ++x) {
                const double dx = x - 127.5, dy = y - 127.5;
                if (dx * dx + dy * dy < radius * radius) holes += pixel(image, x, y)[2] != 200;
            }
        EXPECT_LT(holes, 20U);
    }
}

// A square sheet of points one apart, with what the texture stage needs of them.
PointCloud sheet_cloud(int side, double z, Rgb16 color) {
    PointCloud cloud;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            cloud.positions.push_back({static_cast<double>(x), static_cast<double>(y), z});
            cloud.colors.push_back(color);
        }
    cloud.normals.assign(cloud.size(), {0.0F, 0.0F, 1.0F});
    cloud.areas.assign(cloud.size(), 1.0F);
    cloud.radii.assign(cloud.size(), 1.0F);
    return cloud;
}

TEST(Render, SplatsBlendTheirColorsInLinearLight) {
    PointCloud cloud = sheet_cloud(32, 0.0, rgb16_from_8bit(0, 0, 0));
    for (std::size_t p = 0; p < cloud.size(); ++p)
        if (p % 32 >= 16) cloud.colors[p] = rgb16_from_8bit(255, 255, 255);
    const Image image = render_points(cloud, quad_view(31 * 8));
    // The step lies between columns 15 and 16. It is symmetric in light, half way in its middle, a
    // ramp of some spacings, and flat elsewhere.
    const int middle = 31 * 4;
    EXPECT_NEAR(pixel(image, middle, middle)[0], 188, 12);
    for (const int x : {middle - 40, middle - 24}) EXPECT_LE(pixel(image, x, middle)[0], 1);
    for (const int x : {middle + 24, middle + 40}) EXPECT_GE(pixel(image, x, middle)[0], 254);
    for (int x = middle - 20; x < middle + 20; ++x)
        EXPECT_LE(pixel(image, x, middle)[0], pixel(image, x + 1, middle)[0]);
}

TEST(Render, SplatsOfAFartherSheetDoNotShine) {
    PointCloud cloud = sheet_cloud(32, 0.0, rgb16_from_8bit(200, 30, 40));
    const PointCloud behind = sheet_cloud(32, -3.0, rgb16_from_8bit(255, 255, 255));
    cloud.positions.insert(cloud.positions.end(), behind.positions.begin(), behind.positions.end());
    cloud.colors.insert(cloud.colors.end(), behind.colors.begin(), behind.colors.end());
    cloud.normals.insert(cloud.normals.end(), behind.normals.begin(), behind.normals.end());
    cloud.areas.resize(cloud.size(), 1.0F);
    cloud.radii.resize(cloud.size(), 1.0F);
    const Image image = render_points(cloud, quad_view(200));
    for (int k = 40; k < 160; ++k)
        ASSERT_EQ(pixel(image, k, 100), (std::array<int, 3>{200, 30, 40}));
}

TEST(Render, LonePointsAreNoLargeDiscs) {
    PointCloud cloud = sheet_cloud(16, 0.0, rgb16_from_8bit(0, 0, 0));
    const std::size_t drawn = num_drawn(render_points(cloud, kFront));
    cloud.radii[0] = 100.0F;
    EXPECT_LT(num_drawn(render_points(cloud, kFront)), drawn + drawn / 10);
}

TEST(Render, EllipticalSplatsAreDrawnAlongTheirAxes) {
    PointCloud cloud = sheet_cloud(2, 0.0, rgb16_from_8bit(0, 0, 0));
    cloud.colors[1] = cloud.colors[3] = rgb16_from_8bit(255, 255, 255);  // x = 1
    cloud.radii.assign(4, 4.0F);
    cloud.axes.assign(4, {{0.1F, 0.0F, 0.0F}, {0.0F, 1.0F, 0.0F}});
    View view = quad_view(256);
    view.zoom *= 0.5;  // 128 pixels per unit, x = 0 at 64, y = 1 too
    // Narrow along x: a fifth of the way from one to the other the nearer one is all there is.
    EXPECT_LT(pixel(render_points(cloud, view), 64 + 25, 64)[0], 5);
    for (TangentAxes& axes : cloud.axes) axes = {{1.0F, 0.0F, 0.0F}, {0.0F, 0.1F, 0.0F}};
    EXPECT_GT(pixel(render_points(cloud, view), 64 + 25, 64)[0], 100);
}

TEST(Render, TransparentPicturesHaveCoverageAsAlpha) {
    View view = quad_view(64);
    view.zoom *= 0.5;
    view.is_transparent = true;
    TexturedMesh model = textured_quad({1, 1, 3, {10, 200, 30}});
    const Image image = render_textured(model, view);
    ASSERT_EQ(image.num_channels, 4);
    const auto at = [&](int x, int y) {
        const std::size_t k = 4 * static_cast<std::size_t>(64 * y + x);
        return std::vector<int>(image.pixels.begin() + static_cast<std::ptrdiff_t>(k),
                                image.pixels.begin() + static_cast<std::ptrdiff_t>(k + 4));
    };
    EXPECT_EQ(at(32, 32), (std::vector<int>{10, 200, 30, 255}));
    EXPECT_EQ(at(2, 2)[3], 0);
    // Moved by a third of a pixel: the border's pixels are covered by thirds, their colour is the
    // surface's alone.
    view.center.x = 1.0 / 3.0 / 32.0 / std::numbers::sqrt2;
    const Image moved = render_textured(model, view);
    const std::size_t border = 4 * (64 * 32 + 15);
    EXPECT_EQ(moved.pixels[border + 3], 85);
    EXPECT_EQ(moved.pixels[border + 1], 200);
}

TEST(Render, LooksAtTheBoxItIsGiven) {
    const Mesh mesh = shapes::cube_mesh();
    View view = kFront;
    for (const Vec3d& p : mesh.positions) view.box.extend(p);
    const Image whole = render_mesh(mesh, false, view);
    EXPECT_EQ(whole.pixels, render_mesh(mesh, false, kFront).pixels);
    view.box.extend(view.box.center() + view.box.extent() * 2.0);
    EXPECT_LT(num_drawn(render_mesh(mesh, false, view)), num_drawn(whole) / 2);
}

TEST(Render, OfNothingIsBackground) {
    EXPECT_EQ(num_drawn(render_points({}, kFront)), 0U);
    EXPECT_EQ(num_drawn(render_mesh({}, true, kFront)), 0U);
    EXPECT_EQ(num_drawn(render_textured({}, kFront)), 0U);
    PointCloud one;
    one.positions = {{1, 2, 3}};
    EXPECT_GT(num_drawn(render_points(one, kFront)), 0U);
}

TEST(Render, DegenerateTrianglesAreHarmless) {
    Mesh mesh = shapes::cube_mesh();
    const Image before = render_mesh(mesh, false, kFront);
    mesh.triangles.push_back({0, 0, 0});
    mesh.triangles.push_back({0, 1, 1});
    EXPECT_EQ(render_mesh(mesh, false, kFront).pixels, before.pixels);
}

TEST(Render, DoesNotDependOnWhereTheModelIs) {
    Mesh mesh = shapes::torus_mesh(16, 32);
    const Image here = render_mesh(mesh, false);
    for (Vec3d& p : mesh.positions) p += Vec3d{4194304.0, -524288.0, 65536.0};
    const Image there = render_mesh(mesh, false);
    int worst = 0;
    std::size_t changed = 0;
    for (std::size_t k = 0; k < here.pixels.size(); ++k) {
        const int d = std::abs(here.pixels[k] - there.pixels[k]);
        worst = std::max(worst, d);
        changed += d > 2;
    }
    EXPECT_LT(changed, 60U);  // samples on an outline may fall to the other side
}

TEST(Render, SplatsAreLaidOverEachOtherInDisplayCodes) {
    PointCloud cloud;
    for (const double z : {0.0, 1.0}) shapes::add_point(cloud, {0, 0, z}, {0, 0, 1});
    shapes::make_splats(cloud, 0.2F, 0.5F);
    cloud.colors = {{0, 65535, 0}, {65535, 0, 0}};
    View view = kFront;
    view.box.extend({-1, -1, 0});
    view.box.extend({1, 1, 1});
    // Red in front stops half, green half of the rest: 0.5 and 0.25 of 0.75.
    const std::array<int, 3> center = pixel(render_points(cloud, view), 128, 128);
    EXPECT_NEAR(center[0], 170, 2);
    EXPECT_NEAR(center[1], 85, 2);
    view.direction = {0, 0, -1};
    EXPECT_NEAR(pixel(render_points(cloud, view), 128, 128)[1], 170, 2);
    // By half or more: 1 - 0.5^2 in the middle; less than half a standard deviation and a bit away.
    const Image image = render_points(cloud, view);
    const double scale = 256 / view.box.diagonal();
    const auto half_covered =
        static_cast<int>(scale * 0.2 * std::sqrt(2 * std::log(0.5 / (1 - std::sqrt(0.5)))));
    EXPECT_NE(pixel(image, 128 + half_covered - 2, 128), kBackground);
    EXPECT_EQ(pixel(image, 128 + half_covered + 2, 128), kBackground);
}

TEST(Render, IsTheSameForAnyNumberOfThreads) {
    Context one, seven;
    one.threads = 1;
    seven.threads = 7;
    const Mesh mesh = shapes::torus_mesh(16, 32);
    const PointCloud cloud = shapes::torus_cloud(2000);
    EXPECT_EQ(render_mesh(mesh, true, {}, one).pixels, render_mesh(mesh, true, {}, seven).pixels);
    EXPECT_EQ(render_points(cloud, {}, one).pixels, render_points(cloud, {}, seven).pixels);
    PointCloud splats = cloud;
    shapes::make_splats(splats, 0.05F, 0.6F);
    EXPECT_EQ(render_points(splats, {}, one).pixels, render_points(splats, {}, seven).pixels);
}

TEST(Render, StopsWhenCancelled) {
    std::stop_source stop;
    stop.request_stop();
    Context context;
    context.stop = stop.get_token();
    EXPECT_THROW(render_mesh(shapes::cube_mesh(), false, {}, context), Error);
}

TEST(Render, RefusesImpossibleViews) {
    const Mesh mesh = shapes::cube_mesh();
    View view;
    view.direction = view.up;
    EXPECT_THROW(render_mesh(mesh, false, view), Error);
    view = {};
    view.width = 0;
    EXPECT_THROW(render_mesh(mesh, false, view), Error);
    view = {};
    view.zoom = 0.0;
    EXPECT_THROW(render_mesh(mesh, false, view), Error);
}

TEST(ContactSheet, PutsPicturesInRows) {
    Image a{2, 2, 3, std::vector<std::uint8_t>(12, 10)};
    Image b{2, 2, 3, std::vector<std::uint8_t>(12, 20)};
    Image c{2, 2, 3, std::vector<std::uint8_t>(12, 30)};
    const Image sheet = contact_sheet({a, b, c}, 2);
    EXPECT_EQ(sheet.width, 4);
    EXPECT_EQ(sheet.height, 4);
    EXPECT_EQ(pixel(sheet, 0, 0)[0], 10);
    EXPECT_EQ(pixel(sheet, 2, 1)[0], 20);
    EXPECT_EQ(pixel(sheet, 1, 3)[0], 30);
    EXPECT_EQ(pixel(sheet, 3, 3), kBackground);
    EXPECT_THROW(contact_sheet({}, 2), Error);
    EXPECT_THROW(contact_sheet({a, {1, 1, 4, {0, 0, 0, 0}}}, 2), Error);
    EXPECT_THROW(contact_sheet({a}, 0), Error);
}

}  // namespace
}  // namespace pointbake
