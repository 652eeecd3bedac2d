// Meshes from OBJ and PLY.
#include "core/color.h"
#include "io/mesh_builder.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

using Uvs = std::array<Vec2f, 3>;

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

TEST(Obj, ReadsPolygonsWithEveryKindOfIndex) {
    const TempFolder folder;
    for (const char* face : {"f 1/1 2/2 3/3 4/4\n", "f -4/-4 -3/-3 -2/-2 -1/-1\n",
                             "f 1/1/1 2/2/1 3/3/1 4/4/1 # quad\n", "f 1/1 2/2 \\\n3/3 4/4\n"}) {
        const TexturedMesh mesh =
            load_mesh(folder.write("a.obj", "# made by hand\r\nvn 0 0 1\n" + kSquare + face));
        ASSERT_EQ(mesh.mesh.triangles.size(), 2U);
        EXPECT_EQ(mesh.mesh.positions.size(), 4U);
        EXPECT_EQ(mesh.mesh.triangles[1], (Triangle{0, 2, 3}));
        EXPECT_EQ(mesh.mesh.uvs[1], (Uvs{Vec2f{0, 1}, Vec2f{1, 0}, Vec2f{0, 0}})) << "v is flipped";
        EXPECT_EQ(mesh.materials.size(), 1U);
        EXPECT_TRUE(mesh.triangle_materials.empty());
    }
}

TEST(Obj, ReadsFacesWithoutTextureCoordinates) {
    const TempFolder folder;
    const TexturedMesh mesh =
        load_mesh(folder.write("a.obj", kSquare + "f 1 2 3\nf 1//1 3//1 4//1"));
    EXPECT_EQ(mesh.mesh.triangles.size(), 2U);
    EXPECT_TRUE(mesh.mesh.uvs.empty());
}

TEST(Obj, ReadsMaterialsAndTextures) {
    const TempFolder folder;
    folder.write("wood grain.png", make_png(2, 1, {255, 0, 0, 0, 255, 0}));
    folder.write("my lib.mtl",
                 "newmtl wood\nKd 0.1 0.1 0.1\nmap_Kd -s 1 1 1 -o 0 0 -clamp on wood grain.png\n"
                 "newmtl red\nKd 1 0.5 0\n");
    const TexturedMesh mesh = load_mesh(
        folder.write("a.obj", "mtllib my lib.mtl\n" + kSquare +
                                  "usemtl red\nf 1/1 2/2 3/3\nusemtl wood\nf 1/1 3/3 4/4\n"
                                  "usemtl red\nf 1 2 4\n"));
    ASSERT_EQ(mesh.materials.size(), 2U);
    ASSERT_EQ(mesh.images.size(), 1U);
    EXPECT_EQ(mesh.images[0].pixels, (std::vector<std::uint8_t>{255, 0, 0, 0, 255, 0}));
    const Material& red = mesh.materials[mesh.triangle_materials[0]];
    const Material& wood = mesh.materials[mesh.triangle_materials[1]];
    EXPECT_EQ(mesh.triangle_materials[2], mesh.triangle_materials[0]);
    EXPECT_EQ(red.name, "red");
    EXPECT_EQ(red.color_image, -1);
    EXPECT_EQ(red.base_color, (std::array<double, 3>{1.0, srgb_to_linear_exact(0.5), 0.0}));
    EXPECT_EQ(wood.color_image, 0);
    EXPECT_EQ(wood.base_color, (std::array<double, 3>{1.0, 1.0, 1.0}))
        << "Kd does not count beside map_Kd";
}

TEST(Obj, MissingTexturesAreWarnings) {
    const TempFolder folder;
    folder.write("a.mtl", "newmtl m\nmap_Kd none.png\n");
    int num_warnings = 0;
    Context context;
    context.log = [&](LogLevel level, std::string_view) {
        num_warnings += level == LogLevel::kWarning ? 1 : 0;
    };
    const std::string faces = kSquare + "usemtl m\nf 1/1 2/2 3/3\n";
    const TexturedMesh mesh = load_mesh(folder.write("a.obj", "mtllib a.mtl\n" + faces), context);
    EXPECT_EQ(mesh.materials[0].color_image, -1);
    EXPECT_EQ(num_warnings, 1);
    load_mesh(folder.write("b.obj", "mtllib none.mtl\n" + faces), context);
    EXPECT_EQ(num_warnings, 2);
    folder.write("none.png", "no image");
    EXPECT_EQ(error_of([&] { load_mesh(folder.path() / "a.obj"); }).code(),
              ErrorCode::kUnsupported);
}

TEST(Obj, ReadsVertexColorsOfBothScales) {
    const TempFolder folder;
    for (const char* text : {"v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n",
                             "v 0 0 0 255 0 0\nv 1 0 0 0 255 0\nv 0 1 0 0 0 255\nf 1 2 3\n"}) {
        const TexturedMesh mesh = load_mesh(folder.write("a.obj", text));
        ASSERT_EQ(mesh.mesh.colors.size(), 3U);
        EXPECT_EQ(mesh.mesh.colors[1], (Rgb16{0, 65535, 0}));
    }
}

TEST(Obj, BadLinesAreNamed) {
    const TempFolder folder;
    const auto expect = [&](const std::string& text, ErrorCode code, const std::string& part) {
        const Error error = error_of([&] { load_mesh(folder.write("a.obj", text)); });
        EXPECT_EQ(error.code(), code) << error.what();
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    };
    expect(kSquare + "f 1 2 9\n", ErrorCode::kInvalidInput, ":9: corner '9' names no vertex");
    expect(kSquare + "f 1 2 0\n", ErrorCode::kInvalidInput, "corner '0'");
    expect(kSquare + "f 1 2 -5\n", ErrorCode::kInvalidInput, "corner '-5'");
    expect(kSquare + "f 1 2 x\n", ErrorCode::kInvalidInput, "corner 'x'");
    expect(kSquare + "f 1/1 2/2 3/7\n", ErrorCode::kInvalidInput, "names no texture coordinate");
    expect("v 0 0\n", ErrorCode::kInvalidInput, ":1: a vertex needs three numbers");
    expect("v 0 0 nan\nv 0 1 0\nv 1 0 0\nf 1 2 3\n", ErrorCode::kInvalidInput, "not finite");
    expect(kSquare, ErrorCode::kEmpty, "no triangles");
    expect("hello world\n", ErrorCode::kUnsupported, "neither OBJ");
    expect("", ErrorCode::kInvalidInput, "empty");
}

TEST(Mesh, WeldsEqualPositionsAndKeepsCornerCoordinates) {
    TexturedMesh mesh;
    mesh.mesh.positions = {{0, 0, 0},    {9, 9, 9}, {1, 0, 0}, {0, 1, 0},
                           {-0.0, 0, 0}, {0, 1, 0}, {-1, 0, 0}};
    mesh.mesh.triangles = {{0, 2, 3}, {4, 5, 6}, {0, 4, 2}};
    mesh.mesh.uvs = {Uvs{Vec2f{0, 0}, {1, 0}, {0, 1}}, Uvs{Vec2f{5, 5}, {6, 6}, {7, 7}}, Uvs{}};
    mesh.mesh.colors.assign(7, Rgb16{});
    mesh.mesh.colors[3] = {65535, 0, 0};
    weld_in_place(mesh, "a");
    EXPECT_EQ(mesh.mesh.positions.size(), 4U) << "(9, 9, 9) is used by none";
    ASSERT_EQ(mesh.mesh.triangles.size(), 2U) << "0 and 4 are one";
    EXPECT_EQ(mesh.mesh.triangles[1], (Triangle{0, 2, 3}));
    EXPECT_EQ(mesh.mesh.uvs[1][0], (Vec2f{5, 5}));
    EXPECT_NEAR(mesh.mesh.colors[2].r, 65535.0 * linear_to_srgb_exact(0.5), 1.0);
}

TEST(PlyMesh, ReadsTextureCoordinatesPerFace) {
    const TempFolder folder;
    folder.write("a_A.png", make_png(1, 1, {1, 2, 3}));
    folder.write("b b.png", make_png(1, 1, {4, 5, 6}));
    for (const char* format : kFormats) {
        std::string ply = make_ply(
            format,
            {three_points(),
             {"face",
              {{"int", "vertex_indices", {{0, 1, 2}, {2, 1, 0}}, "uchar"},
               {"float", "texcoord", {{0, 0, 1, 0, 0, 1}, {0.5, 0.25, 1, 0, 0, 1}}, "uchar"},
               column("int", "texnumber", {1, 0})}}});
        ply.insert(4, "comment TextureFile <this>_A.png\ncomment TextureFile   b b.png \n");
        const TexturedMesh mesh = load_mesh(folder.write("a.ply", ply));
        ASSERT_EQ(mesh.mesh.uvs.size(), 2U);
        EXPECT_EQ(mesh.mesh.uvs[0], (Uvs{Vec2f{0, 1}, Vec2f{1, 1}, Vec2f{0, 0}}));
        EXPECT_EQ(mesh.mesh.uvs[1][0], (Vec2f{0.5F, 0.75F}));
        ASSERT_EQ(mesh.images.size(), 2U);
        EXPECT_EQ(mesh.triangle_materials, (std::vector<Index>{1, 0}));
        EXPECT_EQ(mesh.images[static_cast<std::size_t>(mesh.materials[1].color_image)].pixels[0],
                  4);
    }
}

TEST(PlyMesh, ReadsTextureCoordinatesPerVertexAndColors) {
    const TempFolder folder;
    using Names = std::array<const char*, 2>;
    for (const Names& names : {Names{"s", "t"}, Names{"u", "v"}, Names{"texture_u", "texture_v"}}) {
        const TexturedMesh mesh = load_mesh(folder.write(
            "a.ply", make_ply("binary_little_endian",
                              {three_points({column("float", names[0], {0, 1, 0}),
                                             column("float", names[1], {0, 0, 0.75}),
                                             column("uchar", "red", {1, 2, 3}),
                                             column("uchar", "green", {1, 2, 3}),
                                             column("uchar", "blue", {1, 2, 3})}),
                               {"face", {{"int", "vertex_indices", {{0, 1, 2}}, "uchar"}}}})));
        EXPECT_EQ(mesh.mesh.uvs[0], (Uvs{Vec2f{0, 1}, Vec2f{1, 1}, Vec2f{0, 0.25F}}));
        EXPECT_EQ(mesh.mesh.colors[2], rgb16_from_8bit(3, 3, 3));
    }
}

TEST(PlyMesh, WithoutFacesIsRefused) {
    const TempFolder folder;
    const auto path = folder.write("a.ply", make_ply("ascii", {three_points()}));
    EXPECT_EQ(error_of([&] { load_mesh(path); }).code(), ErrorCode::kInvalidInput);
}

}  // namespace
}  // namespace pointbake::test
