// PLY: faces of a cloud's file.
#include "io/test_files.h"

namespace pointbake::test {
namespace {

/// Positions of a triangle's corners.
std::array<Vec3d, 3> corners(const Mesh& mesh, std::size_t t) {
    return {mesh.positions[mesh.triangles[t][0]], mesh.positions[mesh.triangles[t][1]],
            mesh.positions[mesh.triangles[t][2]]};
}

/// Six points on the x axis' sides; row i is at (i, i % 2, 0), but row 5 equals row 0.
TestElement six_points() {
    return {"vertex",
            {column("float", "x", {0, 1, 2, 3, 4, 0}), column("float", "y", {0, 1, 0, 1, 0, 0}),
             column("float", "z", {0, 0, 0, 0, 0, 0})}};
}

TEST(PlyFaces, SplitsPolygonsThroughMergesAndOrder) {
    for (const char* format : kFormats)
        for (const char* name : {"vertex_index", "vertex_indices"}) {
            const TestElement face{"face",
                                   {column("uchar", "flags", {0, 0}),
                                    {"int", name, {{5, 1, 2}, {0, 2, 4, 3, 1}}, "uchar"},
                                    column("uchar", "red", {9, 9})}};
            const LoadResult result = load_bytes(make_ply(format, {six_points(), face}));
            ASSERT_TRUE(result.mesh.has_value());
            const Mesh& mesh = *result.mesh;
            EXPECT_EQ(mesh.positions, result.cloud.positions);
            ASSERT_EQ(mesh.triangles.size(), 4U);
            EXPECT_EQ(corners(mesh, 0),
                      (std::array<Vec3d, 3>{Vec3d{0, 0, 0}, Vec3d{1, 1, 0}, Vec3d{2, 0, 0}}));
            EXPECT_EQ(corners(mesh, 3),
                      (std::array<Vec3d, 3>{Vec3d{0, 0, 0}, Vec3d{3, 1, 0}, Vec3d{1, 1, 0}}));
            EXPECT_EQ(result.report.num_bad_faces, 0U);
        }
}

TEST(PlyFaces, DropsAndCountsBadOnes) {
    TestElement points = six_points();
    points.properties[2].rows[4] = {HUGE_VAL};  // row 4 is no point
    const TestElement face{
        "face",
        {{"int",
          "vertex_indices",
          {{0, 1, 2}, {0, 1, 6}, {0, -1, 2}, {0, 1}, {}, {0, 5, 1}, {1, 2, 4}, {0, 5, 1, 2}},
          "uchar"}}};
    for (const char* format : kFormats) {
        const LoadResult result = load_bytes(make_ply(format, {points, face}));
        EXPECT_EQ(result.mesh->triangles.size(), 2U);
        EXPECT_EQ(result.report.num_bad_faces, 6U);
    }
}

TEST(PlyFaces, UnrollsTriangleStrips) {
    const TestElement strips{"tristrips",
                             {{"int", "vertex_indices", {{0, 1, 2, 3, -1, 1, 3, 2}}, "int"}}};
    for (const char* format : kFormats) {
        const LoadResult result = load_bytes(make_ply(format, {six_points(), strips}));
        ASSERT_TRUE(result.mesh.has_value());
        ASSERT_EQ(result.mesh->triangles.size(), 3U);
        for (std::size_t t = 0; t < 3; ++t) {
            const auto c = corners(*result.mesh, t);
            EXPECT_LT(cross(c[1] - c[0], c[2] - c[0]).z, 0.0) << "all have the same orientation";
        }
    }
}

TEST(PlyFaces, ReadsFacesThatComeBeforeTheirPoints) {
    const TestElement face{"face", {{"uint", "vertex_indices", {{0, 1, 2}}, "uint"}}};
    for (const char* format : kFormats)
        EXPECT_EQ(load_bytes(make_ply(format, {face, six_points()})).mesh->triangles.size(), 1U);
}

TEST(PlyFaces, ManyFacesComeInTheirOrder) {
    TestElement points{"vertex", {}};
    std::vector<double> x, zero;
    TestElement face{"face", {{"int", "vertex_indices", {}, "uchar"}}};
    for (int i = 0; i < 5000; ++i) {
        x.push_back(i);
        zero.push_back(i % 2);
        if (i > 1) face.properties[0].rows.push_back({i - 2.0, i - 1.0, i * 1.0});
    }
    points.properties = {column("int", "x", x), column("int", "y", zero), column("int", "z", zero)};
    for (const char* format : kFormats) {
        const LoadResult result = load_bytes(make_ply(format, {points, face}));
        ASSERT_EQ(result.mesh->triangles.size(), 4998U);
        for (std::size_t t = 0; t < 4998; ++t)
            EXPECT_EQ(corners(*result.mesh, t)[0].x, static_cast<double>(t));
    }
}

}  // namespace
}  // namespace pointbake::test
