#include <draco/compression/decode.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>

#include "pointbake/write.h"
#include "support/check_glb.h"
#include "write/placement.h"
#include "write/write_fixtures.h"

namespace pointbake {
namespace {

using fixtures::Folder;
using fixtures::patch_grid;
using fixtures::read_text;
using fixtures::tetrahedron;
using ::testing::Contains;
using Json = nlohmann::json;

/// A GLB as it lies in the file.
struct Glb {
    Json document;
    std::string binary;
};
Glb read_glb(const std::filesystem::path& path) {
    const std::string bytes = read_text(path);
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data() + 12, 4);
    return {Json::parse(bytes.substr(20, size)), bytes.substr(28 + size)};
}

/// What a decoder finds: triangles of positions and texture coordinates.
struct Corner {
    Vec3f position;
    Vec2f uv;
    Vec3f normal;
};
using Triangles = std::vector<std::array<Corner, 3>>;

template <class T>
std::vector<T> unpacked_view(const Glb& glb, std::size_t view_index, bool is_index) {
    const Json& packed =
        glb.document["bufferViews"][view_index]["extensions"]["EXT_meshopt_compression"];
    const auto* bytes = reinterpret_cast<const unsigned char*>(glb.binary.data()) +
                        packed["byteOffset"].get<std::size_t>();
    const std::size_t size = packed["byteLength"], count = packed["count"],
                      stride = packed["byteStride"];
    std::vector<T> out(count * stride / sizeof(T));
    EXPECT_EQ(is_index ? meshopt_decodeIndexBuffer(out.data(), count, stride, bytes, size)
                       : meshopt_decodeVertexBuffer(out.data(), count, stride, bytes, size),
              0);
    if (packed["filter"] == "EXPONENTIAL") meshopt_decodeFilterExp(out.data(), count, stride);
    return out;
}

Triangles decode_meshopt(const Glb& glb) {
    Triangles out;
    for (const Json& primitive : glb.document["meshes"][0]["primitives"]) {
        const auto view = [&](const Json& accessor) {
            return glb.document["accessors"][accessor.get<std::size_t>()]["bufferView"]
                .get<std::size_t>();
        };
        const Json& attributes = primitive["attributes"];
        const auto positions = unpacked_view<Vec3f>(glb, view(attributes["POSITION"]), false);
        std::vector<Vec2f> uvs(positions.size());
        if (attributes.contains("TEXCOORD_0"))
            uvs = unpacked_view<Vec2f>(glb, view(attributes["TEXCOORD_0"]), false);
        std::vector<Vec3f> normals(positions.size());
        if (attributes.contains("NORMAL"))
            normals = unpacked_view<Vec3f>(glb, view(attributes["NORMAL"]), false);
        const auto indices = unpacked_view<std::uint16_t>(glb, view(primitive["indices"]), true);
        for (std::size_t i = 0; i < indices.size(); ++i) {
            if (i % 3 == 0) out.emplace_back();
            out.back()[i % 3] = {positions[indices[i]], uvs[indices[i]], normals[indices[i]]};
        }
    }
    return out;
}

Triangles decode_draco(const Glb& glb) {
    Triangles out;
    for (const Json& primitive : glb.document["meshes"][0]["primitives"]) {
        const Json& packed = primitive["extensions"]["KHR_draco_mesh_compression"];
        const Json& view = glb.document["bufferViews"][packed["bufferView"].get<std::size_t>()];
        draco::DecoderBuffer buffer;
        buffer.Init(glb.binary.data() + view["byteOffset"].get<std::size_t>(),
                    view["byteLength"].get<std::size_t>());
        auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
        if (!decoded.ok()) {
            ADD_FAILURE() << decoded.status().error_msg_string();
            return out;
        }
        const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
        const auto accessor = [&](const Json& index) {
            return glb.document["accessors"][index.get<std::size_t>()];
        };
        EXPECT_EQ(mesh->num_points(), accessor(primitive["attributes"]["POSITION"])["count"]);
        EXPECT_EQ(3 * mesh->num_faces(), accessor(primitive["indices"])["count"]);
        const auto read = [&](const char* name, draco::PointIndex point, auto& value) {
            if (!packed["attributes"].contains(name)) return;
            mesh->GetAttributeByUniqueId(packed["attributes"][name].get<std::uint32_t>())
                ->GetMappedValue(point, &value);
        };
        for (std::uint32_t f = 0; f < mesh->num_faces(); ++f) {
            out.emplace_back();
            for (std::size_t k = 0; k < 3; ++k) {
                const draco::PointIndex point = mesh->face(draco::FaceIndex(f))[k];
                read("POSITION", point, out.back()[k].position);
                read("TEXCOORD_0", point, out.back()[k].uv);
                read("NORMAL", point, out.back()[k].normal);
            }
        }
    }
    return out;
}

Triangles decode(const std::filesystem::path& path, Compression compress) {
    const Glb glb = read_glb(path);
    return compress == Compression::kDraco ? decode_draco(glb) : decode_meshopt(glb);
}

/// The nearest of a triangle's turns to a model's triangle.
double distance(const std::array<Corner, 3>& t, const TexturedMesh& model, std::size_t number,
                double uv_weight) {
    double best = HUGE_VAL;
    for (std::size_t turn = 0; turn < 3; ++turn) {
        double worst = 0.0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Corner& c = t[(k + turn) % 3];
            const Vec3d p = model.mesh.positions[model.mesh.triangles[number][k]];
            worst = std::max(worst, length(vec_cast<double>(c.position) - p));
            const Vec2f d = c.uv - model.mesh.uvs[number][k];
            worst = std::max(
                worst, uv_weight * static_cast<double>(std::max(std::fabs(d.x), std::fabs(d.y))));
        }
        best = std::min(best, worst);
    }
    return best;
}

constexpr Compression kBoth[] = {Compression::kMeshopt, Compression::kDraco};

/// Of cells as small as 1e-5, which six decimals would lose.
TEST(Compression, MovesNoVertexByMoreThanFloatsMayAndNoTextureByMoreThanAFractionOfATexel) {
    for (const double cell : {1.0, 1e-5}) {
        const TexturedMesh model = patch_grid(14, 2, {}, cell);
        Box box;
        for (const Vec3d& p : model.mesh.positions) box.extend(p);
        const double allowed = kMaxFloatLoss * box.diagonal();
        for (const Compression compress : kBoth) {
            const Folder folder;
            write_model(model, folder / "a.glb", {.compress = compress});
            const Triangles triangles = decode(folder / "a.glb", compress);
            ASSERT_EQ(triangles.size(), model.mesh.triangles.size());
            // 2^-21 of a page weighs as much as the whole allowance, and floats a bit more.
            const double uv_weight = allowed / (std::ldexp(1.0, -21) + 1e-7);
            std::vector<int> found(triangles.size(), 0);
            for (const auto& t : triangles)
                for (std::size_t i = 0; i < triangles.size(); ++i)
                    found[i] += distance(t, model, i, uv_weight) <= allowed ? 1 : 0;
            EXPECT_THAT(found, ::testing::Each(1)) << to_word(compress) << " " << cell;
        }
    }
}

TEST(Compression, BoundsOfPositionsAreThoseOfADecoder) {
    for (const Compression compress : kBoth) {
        const Folder folder;
        write_model(patch_grid(14, 1, {0.3, 0.1, 7.0}, 0.01), folder / "a.glb",
                    {.compress = compress});
        const Json accessor = read_glb(folder / "a.glb").document["accessors"][0];
        Vec3f low{1e9F, 1e9F, 1e9F}, high{-1e9F, -1e9F, -1e9F};
        for (const auto& t : decode(folder / "a.glb", compress))
            for (const Corner& c : t)
                for (std::size_t k = 0; k < 3; ++k) {
                    low[k] = std::min(low[k], c.position[k]);
                    high[k] = std::max(high[k], c.position[k]);
                }
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_EQ(accessor["min"][k].get<float>(), low[k]) << to_word(compress);
            EXPECT_EQ(accessor["max"][k].get<float>(), high[k]) << to_word(compress);
        }
    }
}

TEST(Compression, LargeCoordinatesAreCarriedByTheNode) {
    const TexturedMesh model = patch_grid(6, 1, {500000.0, 5000000.0, 100.0}, 0.1);
    for (const Compression compress : kBoth) {
        const Folder folder;
        const WriteReport report = write_model(model, folder / "a.glb", {.compress = compress});
        EXPECT_NE(report.global_shift, Vec3d{});
        double farthest = 0.0;
        for (const auto& t : decode(folder / "a.glb", compress))
            for (const Corner& c : t) {
                double nearest = HUGE_VAL;
                for (const Vec3d& p : model.mesh.positions)
                    nearest = std::min(
                        nearest, length(vec_cast<double>(c.position) + report.global_shift - p));
                farthest = std::max(farthest, nearest);
            }
        EXPECT_LE(farthest, kMaxFloatLoss * 1.0) << to_word(compress);
    }
}

TEST(Compression, KeepsNormalsUnitAndInPlace) {
    TexturedMesh model = tetrahedron();
    for (const Vec3d& p : model.mesh.positions)
        model.mesh.normals.push_back(vec_cast<float>(normalized(p - Vec3d{0.3, 0.2, 0.1})));
    model.mesh.uvs.assign(4, {});
    for (const Compression compress : kBoth) {
        const Folder folder;
        write_model(model, folder / "a.glb", {.shading = Shading::kLit, .compress = compress});
        const Triangles triangles = decode(folder / "a.glb", compress);
        ASSERT_EQ(triangles.size(), 4U);
        for (const auto& t : triangles)
            for (const Corner& c : t) {
                double best = 0.0;
                for (std::size_t v = 0; v < 4; ++v)
                    if (length(vec_cast<double>(c.position) - model.mesh.positions[v]) < 1e-5)
                        best = static_cast<double>(dot(c.normal, model.mesh.normals[v]));
                EXPECT_NEAR(best, 1.0, 1e-4) << to_word(compress);
            }
    }
}

TEST(Compression, SaysWhatAReaderMustKnowAndIsSmaller) {
    const Folder folder;
    TexturedMesh model = patch_grid(40, 1);
    model.images[0] = fixtures::random_image(4, 4, 3, 1);
    write_model(model, folder / "none.glb");
    write_model(model, folder / "meshopt.glb", {.compress = Compression::kMeshopt});
    write_model(model, folder / "draco.glb", {.compress = Compression::kDraco});
    for (const auto& [name, extension] : {std::pair{"meshopt.glb", "EXT_meshopt_compression"},
                                          std::pair{"draco.glb", "KHR_draco_mesh_compression"}}) {
        const Json document = read_glb(folder / name).document;
        EXPECT_THAT(document["extensionsUsed"], Contains(extension));
        EXPECT_THAT(document["extensionsRequired"], Contains(extension));
        EXPECT_LT(read_text(folder / name).size(), 7 * read_text(folder / "none.glb").size() / 10)
            << name;
    }
}

TEST(Compression, IsTheSameOnEveryRun) {
    for (const Compression compress : kBoth) {
        const Folder folder;
        write_model(patch_grid(20, 2), folder / "a.glb", {.compress = compress});
        write_model(patch_grid(20, 2), folder / "b.glb", {.compress = compress});
        EXPECT_EQ(read_text(folder / "a.glb"), read_text(folder / "b.glb"));
    }
}

TEST(Compression, PassesTheKhronosValidator) {
    const Folder folder;
    std::vector<std::filesystem::path> files;
    for (const Compression compress : kBoth) {
        const std::string name(to_word(compress));
        TexturedMesh colored = tetrahedron();
        colored.mesh.colors.assign(4, Rgb16{65535, 30000, 0});
        for (const auto& [ending, model] : {std::pair{".glb", patch_grid(12, 2)},
                                            {".gltf", patch_grid(5, 1)},
                                            {"-c.glb", colored}}) {
            files.push_back(folder / (name + ending));
            write_model(model, files.back(), {.compress = compress});
        }
    }
    const ValidatorResult result = run_gltf_validator(POINTBAKE_TEST_SUPPORT, files);
    if (!result.is_available)
        GTEST_SKIP() << "THE KHRONOS VALIDATOR DID NOT RUN: " << result.output
                     << "run 'npm ci' in tests/support";
    EXPECT_TRUE(result.is_clean) << result.output;
}

}  // namespace
}  // namespace pointbake
