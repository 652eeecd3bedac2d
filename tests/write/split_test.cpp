#include "write/split.h"

#include <gtest/gtest.h>

#include "core/adjacency.h"
#include "write/placement.h"
#include "write/tangents.h"
#include "write/write_fixtures.h"

namespace pointbake {
namespace {

using fixtures::error_of;
using fixtures::patch_grid;
using fixtures::tetrahedron;

TEST(Split, KeepsSharedVerticesWhereTextureCoordinatesAgree) {
    TexturedMesh model = tetrahedron();
    for (const Triangle& t : model.mesh.triangles)
        model.mesh.uvs.push_back({Vec2f{static_cast<float>(t[0]), 0},
                                  Vec2f{static_cast<float>(t[1]), 0},
                                  Vec2f{static_cast<float>(t[2]), 0}});
    const SplitOptions by_uv{.by_uv = true};
    EXPECT_EQ(split_by_material(model, model.mesh.triangles, {&by_uv, 1})[0].corners.size(), 4U);
    model.mesh.uvs[2][1].y = 0.5F;  // one corner moves: one vertex more
    EXPECT_EQ(split_by_material(model, model.mesh.triangles, {&by_uv, 1})[0].corners.size(), 5U);
    const SplitOptions plain;
    EXPECT_EQ(split_by_material(model, model.mesh.triangles, {&plain, 1})[0].corners.size(), 4U);
}

TEST(Split, EveryCornerFindsItsVertexAndTextureCoordinate) {
    const TexturedMesh model = patch_grid(20, 2);
    const std::vector<SplitOptions> options(2, {.by_uv = true});
    const auto parts = split_by_material(model, model.mesh.triangles, options);
    ASSERT_EQ(parts.size(), 2U);
    std::size_t num_triangles = 0;
    for (const MeshPart& part : parts) {
        std::size_t i = 0;
        for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t) {
            if (model.triangle_materials[t] != part.material) continue;
            ++num_triangles;
            for (std::size_t k = 0; k < 3; ++k) {
                const Index corner = part.corners[part.indices[i++]];
                EXPECT_EQ(model.mesh.triangles[corner / 3][corner % 3], model.mesh.triangles[t][k]);
                EXPECT_EQ(model.mesh.uvs[corner / 3][corner % 3], model.mesh.uvs[t][k]);
            }
        }
        EXPECT_EQ(i, part.indices.size());
    }
    EXPECT_EQ(num_triangles, model.mesh.triangles.size());
}

TEST(Split, ManyTrianglesAroundOneVertexStayFast) {
    TexturedMesh model;
    const Index n = 200000;
    model.mesh.positions.assign(n + 1, Vec3d{});
    for (Index i = 1; i < n; ++i) {
        model.mesh.triangles.push_back({0, i, i + 1});
        const auto u = static_cast<float>(i);
        model.mesh.uvs.push_back({Vec2f{u, 0}, Vec2f{u, 1}, Vec2f{u, 2}});
    }
    const SplitOptions by_uv{.by_uv = true};
    EXPECT_EQ(split_by_material(model, model.mesh.triangles, {&by_uv, 1})[0].corners.size(),
              3U * (n - 1));
}

TEST(Split, ContractsWhatFloatsCannotTellApart) {
    // An octahedron one of whose upper edges is split by a vertex that floats do not keep.
    std::vector<Vec3d> p = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    p.push_back({1.0 - 1e-12, 0, 1e-12});
    const std::vector<Triangle> triangles = {{0, 1, 6}, {6, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 6, 4},
                                             {3, 0, 6}, {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}};
    std::vector<Vec3f> floats;
    for (const Vec3d& q : p)
        floats.push_back({static_cast<float>(q.x), static_cast<float>(q.y),
                          q.z < 1e-9 && q.z > 0 ? 0.0F : static_cast<float>(q.z)});
    TexturedMesh model;
    model.mesh.positions = p;
    model.mesh.triangles = triangles;
    const SplitOptions plain;
    const auto contracted = contract_equal(triangles, floats);
    const MeshPart part = split_by_material(model, contracted, {&plain, 1})[0];
    std::vector<Triangle> rest;
    for (std::size_t i = 0; i < part.indices.size(); i += 3)
        rest.push_back({part.indices[i], part.indices[i + 1], part.indices[i + 2]});
    EXPECT_EQ(rest.size(), 8U);
    EXPECT_TRUE(topology(part.corners.size(), rest).is_closed_manifold());
}

TEST(Split, RefusesModelsThatContradictThemselves) {
    const auto code = [](auto change) {
        TexturedMesh model = patch_grid(2, 2);
        change(model);
        const auto thrown = error_of([&] { check_model(model); });
        return thrown ? thrown->code : ErrorCode::kCancelled;
    };
    constexpr auto kBad = ErrorCode::kInvalidInput;
    EXPECT_EQ(code([](TexturedMesh& m) { m.mesh.triangles[1][2] = 99; }), kBad);
    EXPECT_EQ(code([](TexturedMesh& m) { m.mesh.positions[1].y = NAN; }), kBad);
    EXPECT_EQ(code([](TexturedMesh& m) { m.mesh.uvs[1][0].x = INFINITY; }), kBad);
    EXPECT_EQ(code([](TexturedMesh& m) { m.mesh.uvs.pop_back(); }), kBad);
    EXPECT_EQ(code([](TexturedMesh& m) { m.mesh.normals.resize(1); }), kBad);
    EXPECT_EQ(code([](TexturedMesh& m) { m.triangle_materials[0] = 2; }), kBad);
    EXPECT_EQ(code([](TexturedMesh& m) { m.images.pop_back(); }), kBad);
}

TEST(Placement, SmallNumbersStayAsTheyAre) {
    const std::vector<Vec3d> p = {{0.1, -0.2, 0.3}, {1, 2, 3}, {5, 5, 5}};
    const std::vector<Triangle> t = {{0, 1, 2}};
    const Placement32 placement = place_as_floats(p, t);
    EXPECT_FALSE(placement.has_translation());
    EXPECT_EQ(placement.positions[0], (Vec3f{0.1F, -0.2F, 0.3F}));
}

TEST(Placement, LargeCoordinatesKeepAMillionthOfTheDiagonal) {
    for (const double size : {0.01, 1.0, 30.0, 5000.0}) {
        for (const Vec3d origin : {Vec3d{5e5, 5e6, 120}, {4e6, 3e5, 4.9e6}, {-1e9, 1e9, 0}}) {
            std::vector<Vec3d> p;
            for (std::uint64_t i = 0; i < 300; ++i)
                p.push_back(origin +
                            size * Vec3d{random_unit(1, i), random_unit(2, i), random_unit(3, i)});
            const std::vector<Triangle> t = {{0, 1, 2}, {3, 4, 5}, {297, 298, 299}};
            const Placement32 placement = place_as_floats(p, t);
            for (std::size_t i = 0; i < p.size(); ++i) {
                const Vec3d back = placement.translation + vec_cast<double>(placement.positions[i]);
                EXPECT_LT(length(back - p[i]), 1e-6 * size);
            }
        }
    }
}

TEST(Placement, UnusedVerticesDecideNothing) {
    std::vector<Vec3d> p = {{0.1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1e9 + 0.25, 0, 0}};
    const std::vector<Triangle> t = {{0, 1, 2}};
    EXPECT_FALSE(place_as_floats(p, t).has_translation());
}

TEST(Placement, TellsThatACoordinateDoesNotFitAFloat) {
    const std::vector<Vec3d> p = {{-1e300, 0, 0}, {1e300, 0, 0}, {0, 1e300, 0}};
    const std::vector<Triangle> t = {{0, 1, 2}};
    EXPECT_EQ(error_of([&] { place_as_floats(p, t); })->code, ErrorCode::kLimit);
}

TEST(Tangents, FollowTheTextureCoordinates) {
    // A square in the plane z = 0, seen from above; u right, v down: image up is +y.
    TexturedMesh model;
    model.mesh.positions = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
    model.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    model.mesh.uvs = {{Vec2f{0, 1}, Vec2f{1, 1}, Vec2f{1, 0}},
                      {Vec2f{1, 1}, Vec2f{0, 0}, Vec2f{1, 0}}};
    const Tangents t = triangle_tangents(model);
    EXPECT_EQ(t.directions[0], (Vec3f{1, 0, 0}));
    EXPECT_EQ(t.signs[0], 1);
    // The second one is mirrored: u runs along -x, up is still +y.
    EXPECT_EQ(t.directions[1], (Vec3f{-1, 0, 0}));
    EXPECT_EQ(t.signs[1], -1);
}

TEST(Tangents, NormalsAreUnitEvenWhereNothingIsKnown) {
    TexturedMesh model = tetrahedron();
    model.mesh.positions.push_back({9, 9, 9});  // in no triangle
    model.mesh.normals = {{0, 0, 2}, {}, {}, {NAN, 0, 0}, {}};
    const std::vector<Vec3f> normals = unit_normals(model.mesh);
    for (const Vec3f& n : normals) EXPECT_NEAR(length(n), 1.0, 1e-6);
    EXPECT_EQ(normals[0], (Vec3f{0, 0, 1}));
    EXPECT_GT(normals[3].z, 0.0F);
}

TEST(Tangents, NormalsDoNotDependOnTheScale) {
    TexturedMesh model = tetrahedron();
    const std::vector<Vec3f> at_one = unit_normals(model.mesh);
    for (Vec3d& p : model.mesh.positions) p = p * 0x1p-300;
    EXPECT_EQ(unit_normals(model.mesh), at_one);
}

}  // namespace
}  // namespace pointbake
