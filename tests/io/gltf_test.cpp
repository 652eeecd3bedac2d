// glTF 2.0, as GLB and as JSON, made by hand here.
#include "core/color.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

template <class T>
std::string raw(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

std::string padded(std::string bytes, char with) {
    while (bytes.size() % 4 != 0) bytes += with;
    return bytes;
}

std::string make_glb(std::string json, std::string binary) {
    json = padded(json, ' ');
    binary = padded(binary, '\0');
    const auto word = [](std::size_t v) {
        return raw(std::vector<std::uint32_t>{static_cast<std::uint32_t>(v)});
    };
    return "glTF" + word(2) + word(28 + json.size() + binary.size()) + word(json.size()) + "JSON" +
           json + word(binary.size()) + std::string("BIN\0", 4) + binary;
}

/// Accessors and views, one after the other in a buffer.
struct Buffer {
    std::string bytes, views, accessors;
    int num_views = 0, num_accessors = 0;

    int add_view(const std::string& data) {
        bytes = padded(bytes, '\0');
        views += std::string(num_views ? "," : "") + R"({"buffer":0,"byteOffset":)" +
                 std::to_string(bytes.size()) + R"(,"byteLength":)" + std::to_string(data.size()) +
                 "}";
        bytes += data;
        return num_views++;
    }
    int add(const std::string& data, int component, int count, const std::string& type,
            bool normalized = false) {
        const int view = add_view(data);
        accessors += std::string(num_accessors ? "," : "") + R"({"bufferView":)" +
                     std::to_string(view) + R"(,"componentType":)" + std::to_string(component) +
                     R"(,"count":)" + std::to_string(count) + R"(,"type":")" + type + "\"" +
                     (normalized ? R"(,"normalized":true})" : "}");
        return num_accessors++;
    }
    std::string json(const std::string& rest, const std::string& uri = "") const {
        return R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":)" +
               std::to_string(bytes.size()) + (uri.empty() ? "" : R"(,"uri":")" + uri + "\"") +
               R"(}],"bufferViews":[)" + views + R"(],"accessors":[)" + accessors + "]," + rest +
               "}";
    }
};

const std::vector<float> kTriangle{0, 0, 0, 1, 0, 0, 0, 1, 0};
const std::string kScene = R"("scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)";

std::string primitive(const std::string& attributes, const std::string& rest = "") {
    return R"("meshes":[{"primitives":[{"attributes":{)" + attributes + "}" + rest + "}]}]";
}

TexturedMesh load_glb(const Buffer& buffer, const std::string& rest) {
    const TempFolder folder;
    return load_mesh(folder.write("a.glb", make_glb(buffer.json(rest), buffer.bytes)));
}

TEST(Gltf, ReadsIndicesOfEveryWidthAndNone) {
    for (int component : {0, 5121, 5123, 5125}) {
        Buffer buffer;
        buffer.add(raw(kTriangle), 5126, 3, "VEC3");
        if (component == 5121) buffer.add(raw<std::uint8_t>({0, 2, 1}), component, 3, "SCALAR");
        if (component == 5123) buffer.add(raw<std::uint16_t>({0, 2, 1}), component, 3, "SCALAR");
        if (component == 5125) buffer.add(raw<std::uint32_t>({0, 2, 1}), component, 3, "SCALAR");
        const TexturedMesh mesh = load_glb(
            buffer, kScene + primitive(R"("POSITION":0)", component ? R"(,"indices":1)" : ""));
        ASSERT_EQ(mesh.mesh.triangles.size(), 1U);
        EXPECT_EQ(mesh.mesh.triangles[0], component ? (Triangle{0, 2, 1}) : (Triangle{0, 1, 2}));
        EXPECT_EQ(mesh.mesh.positions[1], (Vec3d{1, 0, 0}));
        EXPECT_TRUE(mesh.mesh.uvs.empty());
        EXPECT_TRUE(mesh.mesh.colors.empty());
    }
}

TEST(Gltf, ReadsStripsAndFans) {
    for (int mode : {5, 6}) {
        Buffer buffer;
        const std::vector<float> quad =
            mode == 5 ? std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}
                      : std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
        buffer.add(raw(quad), 5126, 4, "VEC3");
        const TexturedMesh mesh = load_glb(
            buffer, kScene + primitive(R"("POSITION":0)", R"(,"mode":)" + std::to_string(mode)));
        ASSERT_EQ(mesh.mesh.triangles.size(), 2U);
        for (const Triangle& t : mesh.mesh.triangles) {
            const auto& p = mesh.mesh.positions;
            EXPECT_EQ(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]).z, 1.0);
        }
    }
}

TEST(Gltf, AppliesNodeTransforms) {
    Buffer buffer;
    buffer.add(raw(kTriangle), 5126, 3, "VEC3");
    const std::string nodes =
        R"("scenes":[{"nodes":[0]}],"nodes":[{"translation":[10,0,0],"children":[1,2]},)"
        R"({"mesh":0,"rotation":[0,0,0.7071067811865476,0.7071067811865476],"scale":[2,3,1]},)"
        R"({"mesh":0,"matrix":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,5,1]}],)";
    const TexturedMesh mesh = load_glb(buffer, nodes + primitive(R"("POSITION":0)"));
    ASSERT_EQ(mesh.mesh.triangles.size(), 2U);
    const auto at = [&](std::size_t t, std::size_t c) {
        return mesh.mesh.positions[mesh.mesh.triangles[t][c]];
    };
    EXPECT_NEAR(length(at(0, 1) - Vec3d{10, 2, 0}), 0.0, 1e-12);
    EXPECT_NEAR(length(at(0, 2) - Vec3d{7, 0, 0}), 0.0, 1e-12);
    // mirrored: the corners' order turns, so that the outside stays outside
    EXPECT_EQ(at(1, 1), (Vec3d{10, 1, 5}));
    EXPECT_EQ(at(1, 2), (Vec3d{9, 0, 5}));
}

TEST(Gltf, ReadsMaterialsTexturesAndColors) {
    Buffer buffer;
    buffer.add(raw(kTriangle), 5126, 3, "VEC3");
    buffer.add(raw<std::uint16_t>({0, 0, 65535, 0, 0, 65535}), 5123, 3, "VEC2", true);
    buffer.add(raw<std::uint8_t>({255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 51, 255}), 5121, 3, "VEC4",
               true);
    const int image = buffer.add_view(make_png(1, 1, {7, 8, 9}));
    const std::string materials =
        R"("images":[{"bufferView":)" + std::to_string(image) +
        R"(,"mimeType":"image/png"}],"textures":[{"source":0}],"materials":[{"name":"unused"},)"
        R"({"name":"m","pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,1,1],)"
        R"("baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":)"
        R"({"scale":[2,1],"offset":[0,0.5]}}}}}],)";
    const TexturedMesh mesh = load_glb(
        buffer, kScene + materials +
                    primitive(R"("POSITION":0,"TEXCOORD_0":1,"COLOR_0":2)", R"(,"material":1)"));
    ASSERT_EQ(mesh.materials.size(), 1U);
    EXPECT_EQ(mesh.materials[0].name, "m");
    EXPECT_EQ(mesh.materials[0].base_color, (std::array<double, 3>{0.5, 0.25, 1.0}));
    ASSERT_EQ(mesh.materials[0].color_image, 0);
    EXPECT_EQ(mesh.images[0].pixels, (std::vector<std::uint8_t>{7, 8, 9}));
    EXPECT_EQ(mesh.mesh.uvs[0], (std::array<Vec2f, 3>{Vec2f{0, 0.5F}, {2, 0.5F}, {0, 1.5F}}));
    EXPECT_EQ(mesh.mesh.colors[0], (Rgb16{65535, 0, 0}));
    EXPECT_NEAR(mesh.mesh.colors[2].b, 65535.0 * linear_to_srgb_exact(0.2), 1.0) << "linear light";
}

TEST(Gltf, WeldsPrimitivesOfSeveralMaterials) {
    Buffer buffer;
    buffer.add(raw(kTriangle), 5126, 3, "VEC3");
    buffer.add(raw<float>({1, 1, 0, 0, 1, 0, 1, 0, 0}), 5126, 3, "VEC3");
    const TexturedMesh mesh = load_glb(
        buffer, kScene + R"("materials":[{"name":"a"},{"name":"b"}],"meshes":[{"primitives":[)"
                         R"({"attributes":{"POSITION":0},"material":1},)"
                         R"({"attributes":{"POSITION":1},"material":0},)"
                         R"({"attributes":{"POSITION":0},"mode":0}]}])");
    EXPECT_EQ(mesh.mesh.positions.size(), 4U);
    EXPECT_EQ(mesh.triangle_materials, (std::vector<Index>{0, 1}));
    EXPECT_EQ(mesh.materials[0].name, "b");
}

TEST(Gltf, ReadsBuffersFromFilesAndDataUris) {
    const TempFolder folder;
    Buffer buffer;
    buffer.add(raw(kTriangle), 5126, 3, "VEC3");
    folder.write("my data.bin", buffer.bytes);
    const std::string rest = kScene + primitive(R"("POSITION":0)");
    TexturedMesh mesh =
        load_mesh(folder.write("a.gltf", "\n " + buffer.json(rest, "my%20data.bin")));
    EXPECT_EQ(mesh.mesh.positions[2], (Vec3d{0, 1, 0}));
    // 36 bytes: zeros but for the two ones
    const std::string base64 = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    mesh = load_mesh(folder.write(
        "b.gltf", buffer.json(rest, "data:application/octet-stream;base64," + base64)));
    EXPECT_EQ(mesh.mesh.positions[2], (Vec3d{0, 1, 0}));
    EXPECT_EQ(
        error_of([&] { load_mesh(folder.write("c.gltf", buffer.json(rest, "none.bin"))); }).code(),
        ErrorCode::kIo);
}

TEST(Gltf, BadFilesAreErrors) {
    const TempFolder folder;
    Buffer buffer;
    buffer.add(raw(kTriangle), 5126, 3, "VEC3");
    buffer.add(raw<std::uint8_t>({0, 1, 3}), 5121, 3, "SCALAR");
    const auto expect = [&](std::string rest, ErrorCode code, const std::string& part) {
        const Error error = error_of([&] { load_glb(buffer, rest); });
        EXPECT_EQ(error.code(), code) << error.what();
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    };
    const ErrorCode bad = ErrorCode::kInvalidInput;
    const std::string plain = primitive(R"("POSITION":0)");
    expect(kScene + primitive(R"("POSITION":0)", R"(,"indices":1)"), bad, "names no vertex");
    expect(kScene + primitive(R"("POSITION":7)"), bad, "no accessors[7]");
    expect(kScene + primitive(R"("POSITION":-1)"), bad, "no non-negative integer");
    expect(kScene + primitive(R"("POSITION":1)"), bad, "no VEC3");
    expect(R"("scenes":[{"nodes":[0]}],"nodes":[{"children":[0]}],)" + plain, bad, "two parents");
    expect(R"("scenes":[{"nodes":[3]}],"nodes":[{"mesh":0}],)" + plain, bad, "no nodes[3]");
    expect(R"("scenes":7,"nodes":[{"mesh":0}],)" + plain, bad, "no scenes[0]");
    expect(kScene + R"("meshes":[{}])", bad, "without primitives");
    expect(R"("scenes":[{}],"nodes":[])", ErrorCode::kEmpty, "no triangles");
    expect(R"("extensionsRequired":["KHR_draco_mesh_compression"],)" + kScene + plain,
           ErrorCode::kUnsupported, "KHR_draco_mesh_compression");
    buffer.accessors.replace(buffer.accessors.find(R"("count":3)"), 9, R"("count":999999999999)");
    expect(kScene + plain, bad, "promises 999999999999 elements");
    EXPECT_EQ(error_of([&] { load_mesh(folder.write("a.gltf", "{ broken")); }).code(), bad);
    EXPECT_EQ(error_of([&] { load_mesh(folder.write("b.gltf", "{}")); }).code(), ErrorCode::kEmpty);
}

TEST(Gltf, EveryCutOfAGlbIsAnError) {
    const TempFolder folder;
    Buffer buffer;
    buffer.add(raw(kTriangle), 5126, 3, "VEC3");
    const std::string whole =
        make_glb(buffer.json(kScene + primitive(R"("POSITION":0)")), buffer.bytes);
    for (std::size_t size = 0; size < whole.size(); ++size)
        error_of([&] { load_mesh(folder.write("a.glb", whole.substr(0, size))); });
    EXPECT_EQ(load_mesh(folder.write("a.glb", whole)).mesh.triangles.size(), 1U);
}

}  // namespace
}  // namespace pointbake::test
