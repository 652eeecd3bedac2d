#include <stop_token>

#include "attributes/clouds.h"
#include "pointbake/attributes.h"

namespace pointbake {
namespace {

/// A surface over the points of a cloud made from a mesh's vertices.
struct Model {
    PointCloud cloud;  ///< positions only
    PointCloud truth;  ///< with outward normals
    DenseMesh surface;
};

Model make_model(Mesh mesh) {
    Model model;
    model.truth.positions = mesh.positions;
    std::vector<Vec3d> normals(mesh.positions.size());
    for (const Triangle& t : mesh.triangles) {
        const Vec3d a = mesh.positions[t[0]];
        for (const Index v : t)
            normals[v] += cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
    }
    for (const Vec3d n : normals) model.truth.normals.push_back(vec_cast<float>(normalized(n)));
    model.cloud = bare(model.truth);
    model.surface.vertex_points.resize(mesh.positions.size());
    std::iota(model.surface.vertex_points.begin(), model.surface.vertex_points.end(), Index{0});
    model.surface.mesh = std::move(mesh);
    return model;
}

PointCloud with_random_signs(PointCloud cloud) {
    for (std::size_t i = 0; i < cloud.size(); ++i)
        if (hash64(99, i) & 1U) cloud.normals[i] = -cloud.normals[i];
    return cloud;
}

TEST(RefineAttributes, OrientsAllNormalsOutward) {
    for (const Mesh& mesh : {shapes::sphere_mesh(8), shapes::torus_mesh(40, 60)}) {
        const Model model = make_model(mesh);
        const AttributesResult result =
            refine_attributes(estimate_attributes(model.cloud).cloud, model.surface);
        EXPECT_EQ(agreement(result.cloud, model.truth), 1.0);
        EXPECT_TRUE(result.report.oriented_by_surface);
    }
}

TEST(RefineAttributes, TurnsGivenNormalsThatPointInward) {
    const Model model = make_model(shapes::torus_mesh(20, 30));
    PointCloud inward = model.truth;
    for (Vec3f& n : inward.normals) n = -n;
    const AttributesResult result =
        refine_attributes(estimate_attributes(inward).cloud, model.surface);
    EXPECT_EQ(result.cloud.normals, model.truth.normals);
    EXPECT_EQ(result.report.num_flipped_normals, inward.size());
}

TEST(RefineAttributes, AreasSumToTheSurfaces) {
    const Model model = make_model(shapes::torus_mesh(30, 50));
    const PointCloud result = refine_attributes(model.cloud, model.surface).cloud;
    EXPECT_NEAR(sum_of_areas(result), area(model.surface.mesh), 3e-3 * area(model.surface.mesh));
    for (std::size_t i = 0; i < result.size(); ++i)
        ASSERT_EQ(result.radii[i], std::sqrt(result.areas[i]));
}

TEST(RefineAttributes, KeepsRadiiThatTheFileGave) {
    Model model = make_model(shapes::sphere_mesh(6));
    model.cloud.radii.assign(model.cloud.size(), 0.25F);
    const PointCloud result = refine_attributes(model.cloud, model.surface).cloud;
    EXPECT_EQ(result.radii, model.cloud.radii);
}

TEST(RefineAttributes, AddsUpVerticesOverOnePoint) {
    const Model model = make_model(shapes::sphere_mesh(6));
    DenseMesh soup;
    for (const Triangle& t : model.surface.mesh.triangles) {
        const auto first = static_cast<Index>(soup.mesh.positions.size());
        soup.mesh.triangles.push_back({first, first + 1, first + 2});
        for (const Index v : t) {
            soup.mesh.positions.push_back(model.surface.mesh.positions[v]);
            soup.vertex_points.push_back(v);
        }
    }
    expect_same_attributes(refine_attributes(model.cloud, soup).cloud,
                           refine_attributes(model.cloud, model.surface).cloud);
}

TEST(RefineAttributes, PointsOffTheSurfaceTakeTheNearestSign) {
    Model model = make_model(shapes::sphere_mesh(8));
    const std::size_t num_vertices = model.cloud.size();
    const PointCloud strays = shapes::sphere_cloud(100, 0.0, 1.02);
    for (const Vec3d p : strays.positions) model.cloud.positions.push_back(p);
    const PointCloud first = estimate_attributes(model.cloud).cloud;
    const PointCloud result = refine_attributes(first, model.surface).cloud;
    for (std::size_t i = num_vertices; i < result.size(); ++i) {
        ASSERT_GT(dot(result.normals[i], vec_cast<float>(result.positions[i])), 0.0F);
    }
    // Strays share the surface with their neighbours: all together still have its area.
    const double all = std::accumulate(result.areas.begin(), result.areas.end(), 0.0);
    const PointCloud bare =
        refine_attributes(make_model(shapes::sphere_mesh(8)).cloud, model.surface).cloud;
    const double surface = std::accumulate(bare.areas.begin(), bare.areas.end(), 0.0);
    EXPECT_NEAR(all, surface, 0.02 * surface);
}

TEST(RefineAttributes, UnknownNormalsBecomeTheSurfaces) {
    Model model = make_model(shapes::sphere_mesh(8));
    PointCloud cloud = estimate_attributes(model.cloud).cloud;
    cloud.normals[3] = cloud.normals[40] = {};
    const AttributesResult result = refine_attributes(cloud, model.surface);
    EXPECT_GT(alignment(result.cloud.normals[3], model.truth.normals[3]), 0.9999);
    EXPECT_EQ(result.report.num_estimated_normals, 2U);
    EXPECT_EQ(result.report.num_invalid_normals, 0U);
}

/// Two flat sheets `gap` spacings apart, the upper one facing up, the lower one down.
Model two_sheets(double gap) {
    const Index n = 20;
    Mesh mesh;
    for (const double side : {1.0, -1.0}) {
        const auto first = static_cast<Index>(mesh.positions.size());
        Mesh sheet = shapes::plane_mesh(n, n);
        for (const Vec3d p : sheet.positions)
            mesh.positions.push_back({p.x, side * p.z, side * gap * 0.05});
        for (const Triangle& t : sheet.triangles)
            mesh.triangles.push_back({first + t[0], first + t[2], first + t[1]});
    }
    return make_model(std::move(mesh));
}

TEST(RefineAttributes, TheSurfaceTellsThinSheetsApartAtAnyDistance) {
    for (const double gap : {4.0, 2.0, 1.0, 0.5}) {
        const Model model = two_sheets(gap);
        ASSERT_EQ(model.truth.normals.front().z, 1.0F);
        ASSERT_EQ(model.truth.normals.back().z, -1.0F);
        PointCloud cloud = with_random_signs(model.truth);
        EXPECT_EQ(agreement(refine_attributes(cloud, model.surface).cloud, model.truth), 1.0);
    }
}

TEST(RefineAttributes, TheSpanningTreeNeedsSheetsApart) {
    // Four spacings apart the sheets are two parts, each turned upward: the lower one comes out
    // inverted as a whole. One spacing apart they are one part, and it faces one way.
    for (const double gap : {4.0, 1.0}) {
        const Model model = two_sheets(gap);
        const PointCloud result = refine_attributes(with_random_signs(model.truth), {}).cloud;
        for (const Vec3f n : result.normals) ASSERT_EQ(n.z, 1.0F);
    }
}

TEST(RefineAttributes, TheSpanningTreeOrientsClosedShapesOutward) {
    for (const PointCloud& truth : {shapes::sphere_cloud(1000), shapes::torus_cloud(3000)}) {
        const PointCloud first = estimate_attributes(bare(truth)).cloud;
        const AttributesResult result = refine_attributes(with_random_signs(first), {});
        EXPECT_EQ(agreement(result.cloud, truth), 1.0);
        EXPECT_FALSE(result.report.oriented_by_surface);
    }
}

TEST(RefineAttributes, TheSpanningTreeDoesNotDependOnTheOrderOfThePoints) {
    const PointCloud torus = with_random_signs(shapes::torus_cloud(1500, 1.0, 0.4, 0.01));
    const PointCloud straight = refine_attributes(torus, {}).cloud;
    const std::vector<Index> order = shuffled_order(torus.size(), 3);
    PointCloud shuffled;
    for (const Index i : order) {
        shuffled.positions.push_back(torus.positions[i]);
        shuffled.normals.push_back(torus.normals[i]);
    }
    const PointCloud result = refine_attributes(shuffled, {}).cloud;
    for (std::size_t k = 0; k < order.size(); ++k)
        ASSERT_EQ(result.normals[k], straight.normals[order[k]]);
}

TEST(RefineAttributes, OrientsByAMeshThatIsNotMadeOfThePoints) {
    const PointCloud truth = shapes::cube_cloud(12);
    const PointCloud result =
        refine_attributes(with_random_signs(truth), {shapes::cube_mesh(), {}}).cloud;
    EXPECT_EQ(agreement(result, truth), 1.0);
}

/// Points `ratio` times farther apart along x than along z.
Model stretched_plane(double ratio) {
    Mesh mesh = shapes::plane_mesh(20, 20);
    for (Vec3d& p : mesh.positions) p = {p.x * ratio, p.y, p.z};
    return make_model(std::move(mesh));
}

TEST(RefineAttributes, FillsAxesAlongAndAcrossScanLines) {
    const Model model = stretched_plane(4.0);
    const PointCloud result = refine_attributes(model.cloud, model.surface).cloud;
    ASSERT_EQ(result.axes.size(), result.size());
    const std::size_t middle = 21 * 10 + 10;
    const Vec3f u = result.axes[middle].u, v = result.axes[middle].v;
    EXPECT_NEAR(length(u) / length(v), 4.0, 0.8);  // the ring leans towards its two diagonals
    EXPECT_NEAR(length(u) * length(v), 0.36F * result.areas[middle], 1e-6);
    EXPECT_GT(std::fabs(u.x), 0.95F * length(u));
    EXPECT_NEAR(dot(u, v), 0.0F, 1e-7F);
    EXPECT_NEAR(dot(u, result.normals[middle]), 0.0F, 1e-7F);
}

TEST(RefineAttributes, LeavesAxesEmptyWherePointsAreAboutAsDenseBothWays) {
    for (const double ratio : {1.0, 1.4}) {
        const Model model = stretched_plane(ratio);
        EXPECT_TRUE(refine_attributes(model.cloud, model.surface).cloud.axes.empty());
    }
}

TEST(RefineAttributes, KeepsAxesThatTheFileGave) {
    Model model = stretched_plane(4.0);
    model.cloud.axes.assign(model.cloud.size(), {{1.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 1.0F}});
    const PointCloud result = refine_attributes(model.cloud, model.surface).cloud;
    for (const TangentAxes& axes : result.axes) ASSERT_EQ(axes.u, (Vec3f{1.0F, 0.0F, 0.0F}));
}

TEST(RefineAttributes, GivesTheSameBytesForAnyNumberOfThreads) {
    Model model = make_model(shapes::torus_mesh(60, 240));  // stretched: axes are filled too
    model.cloud.positions.push_back({5.0, 0.0, 0.0});
    for (const DenseMesh& surface : {model.surface, DenseMesh{}}) {
        const PointCloud one = refine_attributes(model.cloud, surface, {}, {.threads = 1}).cloud;
        expect_same_attributes(one,
                               refine_attributes(model.cloud, surface, {}, {.threads = 7}).cloud);
    }
}

TEST(RefineAttributes, TakesFewPoints) {
    for (const std::size_t count : {0U, 1U, 2U, 3U}) {
        PointCloud cloud;
        for (std::size_t i = 0; i < count; ++i)
            cloud.positions.push_back({static_cast<double>(i), 0.0, 0.0});
        EXPECT_EQ(refine_attributes(cloud, {}).report.num_invalid_normals, count);
    }
}

TEST(RefineAttributes, RefusesASurfaceOfOtherPoints) {
    Model model = make_model(shapes::sphere_mesh(3));
    model.surface.vertex_points.back() = 100000;
    expect_error(ErrorCode::kInvalidInput, [&] { refine_attributes(model.cloud, model.surface); });
    model.surface.vertex_points.pop_back();
    expect_error(ErrorCode::kInvalidInput, [&] { refine_attributes(model.cloud, model.surface); });
}

TEST(RefineAttributes, StopsWhenTold) {
    std::stop_source stop;
    stop.request_stop();
    const Model model = make_model(shapes::sphere_mesh(3));
    expect_error(ErrorCode::kCancelled, [&] {
        refine_attributes(model.truth, model.surface, {}, {.stop = stop.get_token()});
    });
}

}  // namespace
}  // namespace pointbake
