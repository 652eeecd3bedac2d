// Files that other programs wrote, where they are at hand.
#include <map>

#include "io/test_files.h"

namespace pointbake::test {
namespace {

namespace fs = std::filesystem;

fs::path data_folder() {
    const char* elsewhere = std::getenv("POINTBAKE_DATA");
    return elsewhere != nullptr ? fs::path(elsewhere) : fs::path(POINTBAKE_TEST_DATA);
}

/// Files of a folder with this extension, by name.
std::vector<fs::path> files_in(const std::string& folder, const std::string& extension) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(data_folder() / folder))
        if (entry.path().extension() == extension) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

TEST(RealFiles, OddPlyFilesReadOrFailClearly) {
    if (!fs::exists(data_folder() / "loaders"))
        GTEST_SKIP() << "no test data in " << data_folder()
                     << "; POINTBAKE_DATA names another folder";
    // The others must open.
    const std::map<std::string, ErrorCode> kErrors{
        {"assimp_invalid_crash-30d6d0f7c529b3b66b4131700b7a4580cd7082df", ErrorCode::kInvalidInput},
        {"assimp_invalid_empty", ErrorCode::kInvalidInput},
        {"pdal_no_vertex", ErrorCode::kInvalidInput},
        {"pdal_sized_dims", ErrorCode::kInvalidInput},    // no z
        {"pdal_unsized_dims", ErrorCode::kInvalidInput},  // no z
        {"trimesh_empty", ErrorCode::kEmpty},
        {"trimesh_ply_empty_ascii", ErrorCode::kEmpty},
        {"trimesh_ply_empty_bin", ErrorCode::kEmpty},
        {"trimesh_ply_empty_header", ErrorCode::kInvalidInput}};
    for (const fs::path& path : files_in("loaders", ".ply")) {
        SCOPED_TRACE(path.filename().string());
        const auto expected = kErrors.find(path.stem().string());
        if (expected != kErrors.end()) {
            EXPECT_EQ(error_of([&] { load_cloud(path); }).code(), expected->second);
            continue;
        }
        const LoadResult result = load_cloud(path);
        EXPECT_GT(result.cloud.size(), 0U);
        EXPECT_EQ(result.report.num_kept + result.report.num_merged + result.report.num_non_finite,
                  result.report.num_rows);
        EXPECT_EQ(result.report.num_bad_faces, 0U);
    }
}

TEST(RealFiles, CountsOfScansAreRight) {
    if (!fs::exists(data_folder() / "colored_points"))
        GTEST_SKIP() << "no test data in " << data_folder()
                     << "; POINTBAKE_DATA names another folder";
    struct Counts {
        const char* name;
        std::uint64_t rows, merged;
        std::size_t triangles;
        bool has_colors, has_normals, has_radii;
    };
    for (const Counts& c :
         {Counts{"colored_points/lion_takanawa", 341989, 49, 0, true, true, false},
          Counts{"colored_points/pond_surfels", 70051, 19, 0, true, true, true},
          Counts{"colored_points/o3d_livingroom_002", 112698, 0, 0, true, false, false},
          Counts{"scans/bunny_zipper", 35947, 0, 69451, false, false, false},
          Counts{"scans/horse_48k", 48485, 0, 96966, true, false, false},
          Counts{"scans/laurana_rangemap_315", 62702, 0, 120995, false, false, false},
          Counts{"scans/pcu_duplicated", 5395, 1345, 0, false, true, false}}) {
        SCOPED_TRACE(c.name);
        const LoadResult result = load_cloud(data_folder() / (std::string(c.name) + ".ply"));
        EXPECT_EQ(result.report.num_rows, c.rows);
        EXPECT_EQ(result.report.num_merged, c.merged);
        EXPECT_EQ(result.mesh ? result.mesh->triangles.size() : 0, c.triangles);
        EXPECT_EQ(!result.cloud.colors.empty(), c.has_colors);
        EXPECT_EQ(!result.cloud.normals.empty(), c.has_normals);
        EXPECT_EQ(!result.cloud.radii.empty(), c.has_radii);
    }
}

// Counts as Open3D 0.16 and NumPy read them; those of splats by a script of their formats; LAS and
// LAZ as laspy 2.7 (lazrs 0.8), E57 as pye57 0.4.19.
TEST(RealFiles, OtherFormatsReadAsOtherProgramsDo) {
    if (!fs::exists(data_folder() / "colored_points"))
        GTEST_SKIP() << "no test data in " << data_folder()
                     << "; POINTBAKE_DATA names another folder";
    struct Counts {
        const char* name;
        std::uint64_t rows, points, left_out;
        bool has_colors, has_normals, has_sensors;
    };
    for (const Counts& c :
         {Counts{"colored_points/o3d_fragment.pcd", 113662, 113662, 0, true, true, false},
          Counts{"colored_points/pcl_table_mug.pcd", 307200, 209280, 0, true, false, true},
          Counts{"scans/pcl_room_scan1.pcd", 112586, 56159, 0, false, false, false},
          Counts{"scans/pcl_biwi_face.pcd", 100000, 100000, 0, false, false, false},
          Counts{"loaders/loadersgl_simple-ascii.pcd", 213, 213, 0, true, false, false},
          Counts{"loaders/pdal_autzen-utm.pcd", 1065, 1065, 0, true, false, false},
          Counts{"loaders/pdal_utm17_comma.pcd", 10, 10, 0, false, false, false},
          Counts{"scans/bunnyData.pts", 30571, 30571, 0, false, false, false},
          Counts{"scans/cgal_cube.pwn", 50000, 50000, 0, false, true, false},
          Counts{"scans/cgal_kitten.xyz", 5210, 5210, 0, false, true, false},
          Counts{"loaders/ripple_ripple.txt", 10201, 10201, 0, true, true, false},
          Counts{"loaders/ripple_ripple.pts", 10201, 10201, 0, true, false, false},
          Counts{"loaders/trimesh_points_cloudcompare.xyz", 101, 101, 0, true, false, false},
          Counts{"loaders/pdal_utm17_3.txt", 11, 10, 1, false, false, false},
          Counts{"loaders/pdal_quoted.txt", 9, 9, 0, false, false, false},
          Counts{"loaders/pdal_1.2-with-color.ptx", 1065, 1065, 0, true, false, false},
          Counts{"loaders/pdal_complex-transform.ptx", 12, 4, 8, true, false, false},
          Counts{"colored_points/autzen_trim.las", 110000, 110000, 0, true, false, false},
          Counts{"colored_points/ign_fields.laz", 697721, 697721, 0, true, false, false},
          Counts{"colored_points/lion_takanawa.copc.laz", 341989, 275855, 0, true, false, false},
          Counts{"colored_points/qcompass_outcrop.laz", 268035, 265479, 0, true, false, false},
          Counts{"loaders/laspy_fullwave.laz", 10750, 10750, 0, true, false, false},
          Counts{"loaders/loadersgl_pdrf8-1.4.laz", 1024, 541, 483, true, false, false},
          Counts{"colored_points/pump.e57", 155201, 155201, 0, true, false, true},
          Counts{"scans/bunnyDouble.e57", 30571, 30571, 0, false, false, false},
          Counts{"loaders/cry_bunnyInt19.e57", 30571, 30571, 0, false, false, false},
          Counts{"loaders/cry_tiny_spherical.e57", 360, 180, 180, false, false, false},
          Counts{"loaders/pye57_testWithNormals.e57", 2, 2, 0, false, true, false},
          Counts{"loaders/pye57_translationWithoutRotation.e57", 4, 3, 1, false, false, true},
          Counts{"gaussians/biker.spz", 152746, 92821, 59847, true, true, false},
          Counts{"gaussians/biker.compressed.ply", 152746, 93148, 59590, true, true, false},
          Counts{"gaussians/lastchance.splat", 14007, 7512, 6495, true, true, false},
          Counts{"gaussians/train_1000_3dgs.ply", 1000, 653, 347, true, true, false}}) {
        SCOPED_TRACE(c.name);
        const LoadResult result = load_cloud(data_folder() / c.name);
        EXPECT_EQ(result.report.num_rows, c.rows);
        EXPECT_EQ(result.report.num_kept, c.points);
        EXPECT_EQ(result.report.num_left_out, c.left_out);
        EXPECT_EQ(!result.cloud.colors.empty(), c.has_colors);
        EXPECT_EQ(!result.cloud.normals.empty(), c.has_normals);
        EXPECT_EQ(!result.cloud.sensors.empty(), c.has_sensors);
    }
    // Its counts are 4444 and 10014.
    EXPECT_EQ(error_of([&] { load_cloud(data_folder() / "loaders/ripple_ripple.ptx"); }).code(),
              ErrorCode::kInvalidInput);
    EXPECT_EQ(error_of([&] { load_cloud(data_folder() / "loaders/vtk_cactus.3337.pts"); }).code(),
              ErrorCode::kInvalidInput);
}

TEST(RealFiles, OddScannerFilesReadOrFailClearly) {
    if (!fs::exists(data_folder() / "loaders"))
        GTEST_SKIP() << "no test data in " << data_folder()
                     << "; POINTBAKE_DATA names another folder";
    // The others must open.
    const std::map<std::string, ErrorCode> kErrors{
        {"loadersgl_pdrf4-1.3.laz", ErrorCode::kUnsupported},  // wave packets
        {"loadersgl_pdrf5-1.3.laz", ErrorCode::kUnsupported},
        {"pdal_1.2-no-points.las", ErrorCode::kInvalidInput},            // promises 1065
        {"pdal_1.2-with-color-clipped.las", ErrorCode::kInvalidInput},   // lacks the last
        {"pdal_garbage_nVariableLength.las", ErrorCode::kInvalidInput},  // lacks the last
        {"pdal_no-points.las", ErrorCode::kEmpty},
        {"cry_corrupt_crc.e57", ErrorCode::kInvalidInput},
        {"libe57_bad-crc.e57", ErrorCode::kInvalidInput},
        {"cry_read_error.e57", ErrorCode::kEmpty},  // zeros alone
        {"cry_empty.e57", ErrorCode::kEmpty},
        {"cry_empty_pc.e57", ErrorCode::kEmpty},
        {"libe57_InvalidCVHeader.e57", ErrorCode::kEmpty},
        {"libe57_PinholeImageWithDistortionParameters.e57", ErrorCode::kEmpty},
        {"libe57_ZeroPoints.e57", ErrorCode::kEmpty},
        {"libe57_ZeroPointsInvalid.e57", ErrorCode::kEmpty},
        {"libe57_empty.e57", ErrorCode::kEmpty}};
    for (const char* extension : {".las", ".laz", ".e57"})
        for (const fs::path& path : files_in("loaders", extension)) {
            SCOPED_TRACE(path.filename().string());
            const auto expected = kErrors.find(path.filename().string());
            if (expected != kErrors.end()) {
                EXPECT_EQ(error_of([&] { load_cloud(path); }).code(), expected->second);
                continue;
            }
            const LoadReport report = load_cloud(path).report;
            EXPECT_GT(report.num_kept, 0U);
            EXPECT_EQ(
                report.num_kept + report.num_merged + report.num_non_finite + report.num_left_out,
                report.num_rows);
        }
}

TEST(RealFiles, TexturedMeshesRead) {
    if (!fs::exists(data_folder() / "textured"))
        GTEST_SKIP() << "no test data in " << data_folder()
                     << "; POINTBAKE_DATA names another folder";
    const std::map<std::string, std::pair<std::size_t, std::size_t>> kSizes{
        {"spot", {2930, 5856}}, {"bob", {5344, 10688}}, {"corset", {9774, 18324}}};
    for (const auto& [name, sizes] : kSizes) {
        const TexturedMesh mesh = load_mesh(data_folder() / "textured" / (name + ".obj"));
        EXPECT_EQ(mesh.mesh.positions.size(), sizes.first);
        EXPECT_EQ(mesh.mesh.triangles.size(), sizes.second);
        EXPECT_EQ(mesh.mesh.uvs.size(), sizes.second);
        EXPECT_EQ(mesh.images.size(), 1U);
    }
}

}  // namespace
}  // namespace pointbake::test
