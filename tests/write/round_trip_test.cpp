// What is written comes back through the loader.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "pointbake/load.h"
#include "pointbake/write.h"
#include "write/write_fixtures.h"

namespace pointbake {
namespace {

using fixtures::Folder;
using fixtures::patch_grid;

/// Triangles with what each corner shows, in an order that does not depend on the file.
struct Corner {
    Vec3d position;
    Vec2f uv;
    std::size_t image_bytes = 0;
    std::uint8_t first_byte = 0;
};
std::vector<std::array<Corner, 3>> sorted_triangles(const TexturedMesh& model) {
    std::vector<std::array<Corner, 3>> out;
    for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t) {
        const std::size_t m = model.triangle_materials.empty() ? 0 : model.triangle_materials[t];
        const Image& image =
            model.images.at(static_cast<std::size_t>(model.materials.at(m).color_image));
        for (std::size_t k = 0; k < 3; ++k) {
            if (k == 0) out.emplace_back();
            out.back()[k] = {model.mesh.positions[model.mesh.triangles[t][k]], model.mesh.uvs[t][k],
                             image.pixels.size(), image.pixels.front()};
        }
    }
    const auto key = [](const std::array<Corner, 3>& t) {
        const Vec3d sum = t[0].position + t[1].position + t[2].position;
        return std::array{std::floor(sum.x * 10 + 0.5), std::floor(sum.y * 10 + 0.5)};
    };
    std::stable_sort(out.begin(), out.end(), [&](auto& a, auto& b) { return key(a) < key(b); });
    return out;
}

TEST(RoundTrip, MeshesComeBackFromEveryFormat) {
    const Folder folder;
    const TexturedMesh model = patch_grid(9, 2, {500000.25, 5000000.5, 10}, 1.0);
    const auto expected = sorted_triangles(model);
    for (const auto& [name, tolerance] :
         {std::pair{"a.glb", 1e-6 * 12}, {"b.gltf", 1e-6 * 12}, {"c.obj", 0.0}, {"d.ply", 0.0}}) {
        write_model(model, folder / name);
        const auto back = sorted_triangles(load_mesh(folder / name));
        ASSERT_EQ(back.size(), expected.size()) << name;
        for (std::size_t t = 0; t < back.size(); ++t) {
            for (std::size_t k = 0; k < 3; ++k) {
                EXPECT_LE(length(back[t][k].position - expected[t][k].position), tolerance) << name;
                EXPECT_NEAR(back[t][k].uv.x, expected[t][k].uv.x, 1e-7) << name;
                EXPECT_NEAR(back[t][k].uv.y, expected[t][k].uv.y, 1e-7) << name;
                EXPECT_EQ(back[t][k].image_bytes, expected[t][k].image_bytes) << name;
                EXPECT_EQ(back[t][k].first_byte, expected[t][k].first_byte) << name;
            }
        }
    }
}

TEST(RoundTrip, CloudsComeBackWithAllAttributes) {
    const Folder folder;
    PointCloud cloud;
    for (std::uint64_t i = 0; i < 100; ++i) {
        const auto f = static_cast<float>(i);
        cloud.positions.push_back({5e5 + 0.1 * static_cast<double>(i), 5e6, 3});
        cloud.colors.push_back({static_cast<std::uint16_t>(i * 601), 7, 65535});
        cloud.normals.push_back({0, 0, 1});
        cloud.radii.push_back(1 + f);
        cloud.areas.push_back(2 + f);
        cloud.axes.push_back({{f, 1, 2}, {3, f, 5}});
        cloud.sensors.push_back({0, 1, 0});
        cloud.weights.push_back(0.5F + f / 400);
    }
    cloud.channels.push_back({"intensity", "", ChannelKind::kScalar, 1, cloud.radii});
    write_cloud(cloud, folder / "a.ply");
    const PointCloud back = load_cloud(folder / "a.ply").cloud;
    ASSERT_EQ(back.size(), cloud.size());
    ASSERT_EQ(back.weights.size(), cloud.size());
    ASSERT_EQ(back.axes.size(), cloud.size());
    ASSERT_EQ(back.sensors.size(), cloud.size());
    ASSERT_EQ(back.channels.size(), 1U);
    for (std::size_t i = 0; i < back.size(); ++i) {
        const std::size_t row = back.rows[i];
        EXPECT_EQ(back.positions[i], cloud.positions[row]);
        EXPECT_EQ(back.colors[i], cloud.colors[row]);
        EXPECT_EQ(back.normals[i], cloud.normals[row]);
        EXPECT_EQ(back.radii[i], cloud.radii[row]);
        EXPECT_EQ(back.areas[i], cloud.areas[row]);
        EXPECT_EQ(back.axes[i].u, cloud.axes[row].u);
        EXPECT_EQ(back.axes[i].v, cloud.axes[row].v);
        EXPECT_EQ(back.sensors[i], cloud.sensors[row]);
        EXPECT_EQ(back.weights[i], cloud.weights[row]);
        EXPECT_EQ(back.channels[0].data[i], cloud.channels[0].data[row]);
    }
}

}  // namespace
}  // namespace pointbake
