// OFF and STL: points with their faces.
#include "core/color.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

const std::string kSquare = "0 0 0\n1 0 0\n1 1 0\n0 1 0.5\n";

TEST(Off, ReadsPointsAndPolygons) {
    for (const std::string head :
         {"OFF\n4 2 0\n", "OFF 4 2 0\n", "OFF\n# made\n\n4 2\n", "# before\nOFF\r\n4 2 0\r\n"}) {
        SCOPED_TRACE(head);
        const LoadResult result = load_as("a.off", head + kSquare + "4 0 1 2 3\n3 0 1 9\n");
        EXPECT_EQ(result.report.format, "OFF");
        EXPECT_EQ(result.cloud.size(), 4U);
        ASSERT_TRUE(result.mesh.has_value());
        EXPECT_EQ(result.mesh->triangles.size(), 2U);
        EXPECT_EQ(result.report.num_bad_faces, 1U);
    }
    const TempFolder folder;
    const auto path = folder.write("a.off", "OFF\n4 1 0\n" + kSquare + "4 0 1 2 3 255 0 0\n");
    EXPECT_EQ(load_mesh(path).mesh.triangles.size(), 2U);
    EXPECT_THROW(load_mesh(folder.write("b.off", "OFF\n4 0 0\n" + kSquare)), Error);
    EXPECT_EQ(load_cloud(folder.path() / "b.off").cloud.size(), 4U);
}

TEST(Off, ReadsColorsAndNormals) {
    const PointCloud both =
        load_as("a.off", "CNOFF\n2 0 0\n0 0 0.5 0 0 2 255 0 7 255\n1 1 1 0 1 0 1 2 3 255\n").cloud;
    EXPECT_EQ(both.colors[point_of_row(both, 0)], rgb16_from_8bit(255, 0, 7));
    EXPECT_EQ(both.normals[point_of_row(both, 0)], (Vec3f{0, 0, 1}));
    const PointCloud floats =
        load_as("a.off", "COFF\n2 0 0\n0 0 0.5 1 0 0.2 1\n1 1 1 0.4 0 0 1\n").cloud;
    EXPECT_EQ(floats.colors[point_of_row(floats, 0)], rgb16_from_8bit(255, 0, 51));
    // MeshLab's plain OFF may have colours, too.
    EXPECT_EQ(load_as("a.off", "OFF\n2 0 0\n0 0 0.5 255 0 7\n1 1 1 1 2 3\n").cloud.colors.size(),
              2U);
    EXPECT_EQ(load_as("a.off", "NOFF\n2 0 0\n0 0 0.5 1 0 0\n1 1 1 0 1 0\n").cloud.normals.size(),
              2U);
}

TEST(Off, FilesThatLieAreErrors) {
    const ErrorCode code = ErrorCode::kInvalidInput;
    expect_load_error("a.off", "OFF\n5 0 0\n" + kSquare, code,
                      "promises 5 vertices, but lines are");
    expect_load_error("a.off", "OFF\n4 4000000000 0\n" + kSquare, code, "4000000000 faces, but");
    expect_load_error("a.off", "OFF\n-4 0 0\n" + kSquare, code, "a.off:2: the numbers of vertices");
    expect_load_error("a.off", "OFF\n1e300 0 0\n" + kSquare, code, "the numbers of vertices");
    expect_load_error("a.off", "OFF\nx y\n", code, "the numbers of vertices");
    expect_load_error("a.off", "OFF", code, "the numbers of vertices");
    expect_load_error("a.off", "OFF\n0 0 0\n", ErrorCode::kEmpty, "0 points");
    expect_load_error("a.off", "OFF BINARY\n", ErrorCode::kUnsupported, "binary OFF");
    expect_load_error("a.off", "4OFF\n1 0 0\n0 0 0 1\n", ErrorCode::kUnsupported, "'4OFF'");
    EXPECT_EQ(
        load_as("a.off", "OFF\n4 1 0\n" + kSquare + "4000000000 0 1 2\n").report.num_bad_faces, 1U);
}

std::string text_stl(int num_facets) {
    std::string out = "solid thing\n";
    for (int i = 0; i < num_facets; ++i)
        out += " facet normal 0 0 1\n  outer loop\n   vertex 0 0 " + std::to_string(i) +
               "\n   vertex 1 0 0\n   vertex 0 1e0 0\n  endloop\n endfacet\n";
    return out + "endsolid thing\n";
}

std::string binary_stl(std::uint32_t num_facets, const std::string& head = "") {
    std::string out = head;
    out.resize(80);
    out.append(reinterpret_cast<const char*>(&num_facets), 4);
    for (std::uint32_t i = 0; i < num_facets; ++i) {
        const float values[12] = {0, 0, 1, 0, 0, static_cast<float>(i), 1, 0, 0, 0, 1, 0};
        out.append(reinterpret_cast<const char*>(values), sizeof values);
        out.append(2, '\0');
    }
    return out;
}

TEST(Stl, ReadsTextAndBinary) {
    for (const std::string& bytes :
         {text_stl(3), binary_stl(3), binary_stl(3, "solid but binary")}) {
        const LoadResult result = load_as("a", bytes);
        EXPECT_EQ(result.report.format, "STL mesh");
        EXPECT_EQ(result.cloud.size(), 5U);
        EXPECT_EQ(result.mesh->triangles.size(), 3U);
        const TempFolder folder;
        EXPECT_EQ(load_mesh(folder.write("a.stl", bytes)).mesh.triangles.size(), 3U);
    }
}

TEST(Stl, FilesThatLieAreErrors) {
    const ErrorCode code = ErrorCode::kInvalidInput;
    std::string huge = binary_stl(3);
    huge.replace(80, 4, "\xff\xff\xff\xff");
    expect_load_error("a.stl", huge, code, "promises 4294967295 triangles, but bytes are");
    expect_load_error("a.stl", "short", code, "5 bytes are no STL file");
    expect_load_error("a.stl", "solid a\nfacet\nvertex 0 0\n", code, "a.stl:3: 'vertex' wants");
    expect_load_error("a.stl",
                      "solid a\nfacet\nvertex 0 0 nan\nvertex 1 1 1\nvertex 2 0 0\nendloop",
                      ErrorCode::kEmpty, "no triangles");
    expect_load_error("a.stl", text_stl(3).substr(0, text_stl(3).rfind("endloop")), code,
                      "the file is cut off within a facet");
    expect_load_error("a.stl", "solid a\nendsolid a\n", ErrorCode::kEmpty, "no triangles");
    expect_load_error("a.stl", binary_stl(0), ErrorCode::kEmpty, "no triangles");
}

TEST(Stl, FacetsThatAreNotFiniteAreDropped) {
    std::string text = text_stl(3), binary = binary_stl(3);
    text.replace(text.find("0 0 1\n   v"), 5, "0 0 nan");
    binary.replace(84 + 50 + 12, 4, "\xff\xff\xff\xff");
    for (const std::string& bytes : {text, binary}) {
        const LoadResult result = load_as("a.stl", bytes);
        EXPECT_EQ(result.mesh->triangles.size(), 2U);
        EXPECT_EQ(result.report.num_bad_faces, 1U);
        EXPECT_TRUE(has_note(result, "1 facet dropped: "));
    }
}

TEST(Stl, AnEndThatLacksIsNoted) {
    EXPECT_FALSE(has_note(load_as("a.stl", text_stl(2)), "endsolid"));
    const std::string cut = text_stl(2).substr(0, text_stl(2).find("endsolid"));
    const LoadResult result = load_as("a.stl", cut);
    EXPECT_EQ(result.mesh->triangles.size(), 2U);
    EXPECT_TRUE(has_note(result, "no 'endsolid' at the end"));
}

TEST(Off, CommentsMayFollowVerticesAndFaces) {
    const LoadResult result = load_as("a.off",
                                      "OFF\n4 2 0 # counts\n0 0 0 # a\n1 0 0 # b\n# c\n0 1 0\n"
                                      "0 0 1\n3 0 1 2 # d\n3 0 1 3\n");
    EXPECT_EQ(result.cloud.size(), 4U);
    EXPECT_EQ(result.mesh->triangles.size(), 2U);
    EXPECT_EQ(result.report.num_left_out, 0U);
}

TEST(Off, FacesHaveWholeNumbersAndNoMoreThanPromised) {
    for (const std::string face : {"3.5 0 1 2 3\n", "3 0.5 1 2\n"}) {
        const LoadResult result = load_as("a.off", "OFF\n4 2 0\n" + kSquare + face + "3 0 1 2\n");
        EXPECT_EQ(result.mesh->triangles.size(), 1U);
        EXPECT_EQ(result.report.num_bad_faces, 1U);
    }
    const LoadResult more = load_as("a.off", "OFF\n4 1 0\n" + kSquare + "3 0 1 2\n3 0 2 3\n");
    EXPECT_EQ(more.mesh->triangles.size(), 1U);
    EXPECT_TRUE(has_note(more, "1 line behind the 1 face promised ignored"));
    // A lone number is a face without corners, no count.
    const LoadResult lone = load_as("a.off", "OFF\n4 2 0\n" + kSquare + "0\n3 0 1 2\n");
    EXPECT_EQ(lone.report.num_bad_faces, 1U);
    EXPECT_EQ(lone.mesh->triangles.size(), 1U);
}

TEST(OffAndStl, EveryCutAndFlipIsAnErrorOrACloud) {
    const TempFolder folder;
    for (const std::string& whole :
         {"OFF\n4 1 0\n" + kSquare + "4 0 1 2 3\n", text_stl(1), binary_stl(2)})
        for (std::size_t i = 0; i < whole.size(); ++i)
            for (int flip : {0, 1, 0x80, 0xff}) {
                std::string bytes = flip == 0 ? whole.substr(0, i) : whole;
                if (flip != 0) bytes[i] = static_cast<char>(bytes[i] ^ flip);
                try {
                    EXPECT_LE(load_cloud(folder.write("a.stl", bytes)).cloud.size(), 30U);
                } catch (const Error& error) {
                    EXPECT_FALSE(std::string(error.what()).empty());
                }
            }
}

}  // namespace
}  // namespace pointbake::test
