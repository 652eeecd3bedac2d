#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/color.h"
#include "pointbake/write.h"
#include "support/check_glb.h"
#include "write/write_fixtures.h"

namespace pointbake {
namespace {

using fixtures::decode_png;
using fixtures::error_of;
using fixtures::Folder;
using fixtures::patch_grid;
using fixtures::read_text;
using fixtures::tetrahedron;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Json = nlohmann::json;

/// Every triangle of the file is the model's, in order, with its texture coordinates.
void expect_same_surface(
    const GlbContents& file, const TexturedMesh& model, double tolerance,
    Vec3d (*turn)(Vec3d) = [](Vec3d p) { return p; }) {
    for (const GlbPrimitive& p : file.primitives) {
        std::size_t i = 0;
        for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t) {
            if (!model.triangle_materials.empty() && model.triangle_materials[t] != p.material)
                continue;
            ASSERT_LT(i, p.triangles.size());
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t v = p.triangles[i][k];
                const Vec3d expected = turn(model.mesh.positions[model.mesh.triangles[t][k]]);
                ASSERT_LE(length(p.positions[v] - expected), tolerance);
                if (p.uvs.empty()) continue;
                ASSERT_EQ(p.uvs[v], model.mesh.uvs[t][k]);
            }
            ++i;
        }
        EXPECT_EQ(i, p.triangles.size());
    }
}

TEST(Gltf, GlbHoldsTheModelAndItsPages) {
    const Folder folder;
    const TexturedMesh model = patch_grid(20, 2);
    const WriteReport report = write_model(model, folder / "a.glb");
    const GlbContents file = check_glb(folder / "a.glb");
    EXPECT_THAT(file.problems, IsEmpty());
    ASSERT_EQ(file.primitives.size(), 2U);
    expect_same_surface(file, model, 1e-5);
    for (std::size_t p = 0; p < 2; ++p)
        EXPECT_EQ(decode_png(file.images[p].data(), file.images[p].size()).pixels,
                  model.images[p].pixels);

    EXPECT_EQ(report.num_draw_calls, 2U);
    EXPECT_EQ(report.num_vertices,
              file.primitives[0].positions.size() + file.primitives[1].positions.size());
    EXPECT_EQ(report.num_bytes, std::filesystem::file_size(folder / "a.glb"));
    EXPECT_THAT(report.files, ElementsAre(folder / "a.glb"));
    EXPECT_EQ(report.global_shift, Vec3d{});
    EXPECT_THAT(folder.names(), ElementsAre("a.glb"));
    EXPECT_THAT(file.document["asset"]["generator"].get<std::string>(), HasSubstr("pointbake "));
    EXPECT_EQ(file.document["extensionsUsed"], Json::array({"KHR_materials_unlit"}));
}

TEST(Gltf, SeparateFilesHoldTheSameModel) {
    const Folder folder;
    const TexturedMesh model = patch_grid(8, 2);
    const WriteReport report = write_model(model, folder / "two words.gltf");
    EXPECT_THAT(folder.names(), ElementsAre("two words.bin", "two words.gltf", "two words_0.png",
                                            "two words_1.png"));
    const GlbContents file = check_glb(folder / "two words.gltf");
    EXPECT_THAT(file.problems, IsEmpty());
    expect_same_surface(file, model, 1e-5);
    std::uint64_t num_bytes = 0;
    for (const auto& path : report.files) num_bytes += std::filesystem::file_size(path);
    EXPECT_EQ(report.files.size(), 4U);
    EXPECT_EQ(report.files.front(), folder / "two words.gltf");
    EXPECT_EQ(report.num_bytes, num_bytes);
}

TEST(Gltf, OnlyPagesThatRepeatAreSampledSo) {
    const Folder folder;
    TexturedMesh model = patch_grid(8, 2);
    model.images[1].repeats = true;
    for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t)
        if (model.triangle_materials[t] == 1)
            for (Vec2f& uv : model.mesh.uvs[t]) uv.x += 0.7F;
    write_model(model, folder / "a.glb");
    const GlbContents file = check_glb(folder / "a.glb");
    EXPECT_THAT(file.problems, IsEmpty());
    ASSERT_EQ(file.document["samplers"].size(), 2U);
    EXPECT_EQ(file.document["samplers"][0]["wrapS"], 33071);
    EXPECT_EQ(file.document["samplers"][1]["wrapS"], 10497);
}

TEST(Gltf, SharedTextureCoordinatesShareVertices) {
    const Folder folder;
    TexturedMesh model = patch_grid(30, 1);
    for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d p = model.mesh.positions[model.mesh.triangles[t][k]];
            model.mesh.uvs[t][k] = {static_cast<float>(p.x / 30), static_cast<float>(p.y / 30)};
        }
    EXPECT_EQ(write_model(model, folder / "a.glb").num_vertices, 31U * 31U);
    EXPECT_THAT(check_glb(folder / "a.glb").problems, IsEmpty());
}

TEST(Gltf, IndicesAreShortWhileTheyFit) {
    // 147 x 147 cells without shared corners: 3 * 2 * 147^2 = 129 654 vertices; 104: 64 896.
    const Folder folder;
    for (const auto& [cells, bytes] : {std::pair{104U, 2}, {147U, 4}}) {
        const TexturedMesh model = patch_grid(cells, 1);
        write_model(model, folder / "a.glb");
        const GlbContents file = check_glb(folder / "a.glb");
        EXPECT_THAT(file.problems, IsEmpty());
        EXPECT_EQ(file.primitives[0].index_bytes, bytes);
        expect_same_surface(file, model, 1e-4);
    }
}

TEST(Gltf, BareGeometryIsLitAndSmooth) {
    const Folder folder;
    const TexturedMesh model = tetrahedron();
    const WriteReport report = write_model(model, folder / "a.glb");
    const GlbContents file = check_glb(folder / "a.glb");
    EXPECT_THAT(file.problems, IsEmpty());
    EXPECT_EQ(report.num_vertices, 4U);
    ASSERT_EQ(file.primitives.size(), 1U);
    EXPECT_EQ(file.primitives[0].normals.size(), 4U);
    EXPECT_LT(file.primitives[0].normals[0].x, -0.5F);  // outwards at the origin's corner
    EXPECT_FALSE(file.document.contains("images"));
    EXPECT_FALSE(file.document.contains("extensionsUsed"));
}

TEST(Gltf, VertexColoursAreLinear) {
    const Folder folder;
    TexturedMesh model = tetrahedron();
    model.mesh.colors = {{0, 0, 0}, {65535, 65535, 65535}, rgb16_from_8bit(128, 64, 1), {1, 2, 3}};
    write_model(model, folder / "a.glb");
    const GlbContents file = check_glb(folder / "a.glb");
    EXPECT_THAT(file.problems, IsEmpty());
    const GlbPrimitive& p = file.primitives[0];
    EXPECT_TRUE(p.normals.empty());
    for (std::size_t v = 0; v < p.positions.size(); ++v) {
        std::size_t original = 0;
        while (!(model.mesh.positions[original] == p.positions[v])) ++original;
        const Rgb16 c = model.mesh.colors[original];
        EXPECT_NEAR(p.colors[v][0], 65535.0 * srgb_to_linear_exact(c.r / 65535.0), 1.0);
        EXPECT_NEAR(p.colors[v][1], 65535.0 * srgb_to_linear_exact(c.g / 65535.0), 1.0);
        EXPECT_NEAR(p.colors[v][2], 65535.0 * srgb_to_linear_exact(c.b / 65535.0), 1.0);
        EXPECT_EQ(p.colors[v][3], 65535);
    }
}

TEST(Gltf, TexturesAreNotMultipliedByVertexColours) {
    const Folder folder;
    TexturedMesh model = patch_grid(3, 1);
    model.mesh.colors.assign(model.mesh.positions.size(), Rgb16{100, 100, 100});
    write_model(model, folder / "a.glb");
    EXPECT_TRUE(check_glb(folder / "a.glb").primitives[0].colors.empty());
}

TEST(Gltf, LitShadingHasTheMeshesNormals) {
    const Folder folder;
    TexturedMesh model = patch_grid(3, 1);
    model.mesh.normals.assign(model.mesh.positions.size(), Vec3f{0, 0.6F, 0.8F});
    write_model(model, folder / "a.glb", {.shading = Shading::kLit});
    const GlbContents file = check_glb(folder / "a.glb");
    EXPECT_THAT(file.problems, IsEmpty());
    EXPECT_FALSE(file.document.contains("extensionsUsed"));
    for (const Vec3f& n : file.primitives[0].normals)
        EXPECT_LT(length(n - Vec3f{0, 0.6F, 0.8F}), 1e-6F);
}

TEST(Gltf, NormalMapsBringTangentsAndLight) {
    const Folder folder;
    TexturedMesh model = patch_grid(4, 1);
    model.images.push_back(fixtures::random_image(16, 16, 3, 4));
    model.materials[0].normal_image = 1;
    for (const bool given : {false, true}) {
        if (given) {
            model.corner_tangents.assign(model.mesh.triangles.size(), Vec3f{0, 2, 0});
            model.corner_tangents[3] = {};  // unknown: any direction will do
            model.tangent_signs.assign(model.mesh.triangles.size(), std::int8_t{-1});
        }
        write_model(model, folder / "a.glb");
        const GlbContents file = check_glb(folder / "a.glb");
        EXPECT_THAT(file.problems, IsEmpty());
        EXPECT_EQ(file.images.size(), 2U);
        if (!given) continue;
        const GlbPrimitive& p = file.primitives[0];
        EXPECT_THAT(p.tangents[p.triangles[0][0]], ElementsAre(0.0F, 1.0F, 0.0F, -1.0F));
    }
}

TEST(Gltf, UnusedMaterialsAndImagesAreLeftOut) {
    const Folder folder;
    TexturedMesh model = patch_grid(4, 2);
    model.triangle_materials.assign(model.mesh.triangles.size(), 1);
    const WriteReport report = write_model(model, folder / "a.glb");
    const GlbContents file = check_glb(folder / "a.glb");
    EXPECT_THAT(file.problems, IsEmpty());
    EXPECT_EQ(report.num_draw_calls, 1U);
    ASSERT_EQ(file.images.size(), 1U);
    EXPECT_EQ(decode_png(file.images[0].data(), file.images[0].size()).pixels,
              model.images[1].pixels);
}

TEST(Gltf, MaterialsMayShareAnImage) {
    const Folder folder;
    TexturedMesh model = patch_grid(4, 2);
    model.materials[1].color_image = 0;
    model.materials[1].base_color = {0.5, 0.25, 2.0};  // out of range: clamped
    write_model(model, folder / "a.glb");
    const GlbContents file = check_glb(folder / "a.glb");
    EXPECT_THAT(file.problems, IsEmpty());
    EXPECT_EQ(file.images.size(), 1U);
    EXPECT_EQ(file.document["materials"][1]["pbrMetallicRoughness"]["baseColorFactor"],
              Json::array({0.5, 0.25, 1.0, 1.0}));
}

TEST(Gltf, LargeCoordinatesAreCarriedByATranslation) {
    const Folder folder;
    for (const Vec3d origin : {Vec3d{500000.123, 5000000.456, 310.7}, {4e6, 3e5, 4.9e6}}) {
        const TexturedMesh model = patch_grid(10, 1, origin, 0.05);
        const WriteReport report = write_model(model, folder / "a.glb");
        const GlbContents file = check_glb(folder / "a.glb");
        EXPECT_THAT(file.problems, IsEmpty());
        expect_same_surface(file, model, 1e-6 * 0.7);
        for (const Vec3f& p : file.primitives[0].stored_positions) EXPECT_LT(length(p), 2.0F);
        const Json& node = file.document["nodes"][0];
        const Vec3d t = report.global_shift;
        EXPECT_EQ(node["translation"], Json::array({t.x, t.y, t.z}));
        EXPECT_EQ(node["extras"]["pointbake"]["global_shift"], node["translation"]);
    }
}

TEST(Gltf, UpAndScaleAreNodeTransforms) {
    const Folder folder;
    const auto write = [&](const TexturedMesh& model, UpAxis up, double scale) {
        write_model(model, folder / "a.glb", {.up = up, .scale = scale});
        GlbContents file = check_glb(folder / "a.glb");
        EXPECT_THAT(file.problems, IsEmpty());
        return file;
    };
    const TexturedMesh small = patch_grid(3, 1);
    expect_same_surface(write(small, UpAxis::kAuto, 1.0), small, 1e-6);
    expect_same_surface(write(small, UpAxis::kY, 1.0), small, 1e-6);
    expect_same_surface(write(small, UpAxis::kY, 0.5), small, 1e-6,
                        [](Vec3d p) { return p * 0.5; });
    expect_same_surface(write(small, UpAxis::kZ, 1.0), small, 1e-6,
                        [](Vec3d p) { return Vec3d{p.x, p.z, -p.y}; });
    expect_same_surface(write(small, UpAxis::kX, 1.0), small, 1e-6,
                        [](Vec3d p) { return Vec3d{-p.y, p.x, p.z}; });
    expect_same_surface(write(small, UpAxis::kMinusY, 1.0), small, 1e-6,
                        [](Vec3d p) { return Vec3d{p.x, -p.y, -p.z}; });
    // With a translation, too: it is in the input's units, below the turn.
    const TexturedMesh far = patch_grid(3, 1, {5e5, 5e6, 100.0});
    expect_same_surface(write(far, UpAxis::kZ, 0.001), far, 1e-8,
                        [](Vec3d p) { return Vec3d{p.x, p.z, -p.y} * 0.001; });
}

const Frame kOregon{.up = UpAxis::kZ,
                    .metres_per_unit = 0.3048,
                    .unit = "foot",
                    .height_unit = {},
                    .crs = {.name = "Oregon",
                            .epsg = 2994,
                            .vertical = "NAVD88",
                            .is_geographic = false,
                            .wkt = "PROJCS[\"Oregon\"]"}};

TEST(Gltf, TheInputsFrameTurnsAndScales) {
    const Folder folder;
    TexturedMesh model = patch_grid(3, 1, {500000.123, 5000000.456, 310.7}, 0.05);
    model.frame = kOregon;
    const WriteReport report = write_model(model, folder / "a.glb");
    const GlbContents file = check_glb(folder / "a.glb");
    EXPECT_THAT(file.problems, IsEmpty());
    expect_same_surface(file, model, 1e-6, [](Vec3d p) { return Vec3d{p.x, p.z, -p.y} * 0.3048; });
    EXPECT_EQ(report.frame, kOregon);
    const Vec3d t = report.global_shift;
    EXPECT_EQ(file.document["nodes"][0]["extras"]["pointbake"],
              (Json{{"global_shift", {t.x, t.y, t.z}},
                    {"up", "z"},
                    {"metres_per_unit", 0.3048},
                    {"crs",
                     {{"name", "Oregon"},
                      {"epsg", 2994},
                      {"vertical", "NAVD88"},
                      {"wkt", "PROJCS[\"Oregon\"]"}}}}));
    // Options overrule it.
    write_model(model, folder / "a.glb", {.up = UpAxis::kY, .scale = 2.0});
    expect_same_surface(check_glb(folder / "a.glb"), model, 1e-6, [](Vec3d p) { return p * 2.0; });
}

TEST(Gltf, TheCoordinateSystemLiesBesideTheModel) {
    const Folder folder;
    std::vector<std::string> warnings;
    const Context context{.log = [&](LogLevel level, std::string_view line) {
        if (level == LogLevel::kWarning) warnings.emplace_back(line);
    }};
    TexturedMesh model = patch_grid(3, 1);
    write_model(model, folder / "a.glb", {}, context);
    EXPECT_EQ(folder.names(), (std::set<std::string>{"a.glb"}));
    model.frame = kOregon;
    for (const char* name : {"a.glb", "b.gltf", "c.obj", "d.ply"}) {
        const std::filesystem::path prj =
            std::filesystem::path(folder / name).replace_extension(".prj");
        for (int again = 0; again < 2; ++again) {
            EXPECT_EQ(write_model(model, folder / name, {}, context).prj, prj);
            EXPECT_EQ(fixtures::read_text(prj), "PROJCS[\"Oregon\"]\n");
        }
    }
    EXPECT_THAT(warnings, IsEmpty());
    // What another program has said there stays.
    std::ofstream(folder / "a.prj") << "PROJCS[\"Elsewhere\"]";
    EXPECT_EQ(write_model(model, folder / "a.glb", {}, context).prj, "");
    EXPECT_EQ(fixtures::read_text(folder / "a.prj"), "PROJCS[\"Elsewhere\"]");
    EXPECT_THAT(warnings, testing::ElementsAre(testing::HasSubstr("left as it is")));
}

TEST(Gltf, SameBytesForAnyNumberOfThreadsAndAnyName) {
    const Folder folder;
    TexturedMesh model = patch_grid(40, 2);
    model.images[0] = fixtures::random_image(800, 900, 3, 6);
    write_model(model, folder / "a.glb", {}, {.threads = 1});
    write_model(model, folder / "b.glb", {}, {.threads = 7});
    write_model(model, folder / "c.GLB", {}, {.threads = 7});
    const std::string one = read_text(folder / "a.glb");
    EXPECT_TRUE(one == read_text(folder / "b.glb"));
    EXPECT_TRUE(one == read_text(folder / "c.GLB"));
}

TEST(Gltf, BadNamesInMaterialsAreReplacedNotFatal) {
    const Folder folder;
    TexturedMesh model = patch_grid(2, 1);
    model.materials[0].name = "caf\xe9";
    write_model(model, folder / "a.glb");
    EXPECT_THAT(check_glb(folder / "a.glb").problems, IsEmpty());
}

TEST(Gltf, TrianglesThatFloatsCollapseAreLeftOut) {
    const Folder folder;
    TexturedMesh model = tetrahedron();
    model.mesh.positions.push_back({1.0 + 1e-12, 0, 0});
    model.mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {4, 2, 3}, {1, 2, 4}, {1, 4, 3}};
    write_model(model, folder / "a.glb");
    const GlbContents file = check_glb(folder / "a.glb");
    EXPECT_THAT(file.problems, IsEmpty());
    EXPECT_EQ(file.primitives[0].triangles.size(), 4U);
    EXPECT_EQ(file.primitives[0].positions.size(), 4U);
}

TEST(Gltf, RefusesWhatCannotBeWrittenAndLeavesNothing) {
    const Folder folder;
    const auto code = [&](const TexturedMesh& model, const char* name, WriteOptions options = {}) {
        const auto thrown = error_of([&] { write_model(model, folder / name, options); });
        EXPECT_THAT(folder.names(), IsEmpty());
        return thrown ? thrown->code : ErrorCode::kCancelled;
    };
    const TexturedMesh model = patch_grid(2, 1);
    EXPECT_EQ(code({}, "a.glb"), ErrorCode::kEmpty);
    EXPECT_EQ(code(model, "a.fbx"), ErrorCode::kUnsupported);
    EXPECT_EQ(code(model, "a"), ErrorCode::kUnsupported);
    EXPECT_EQ(code(model, "none/a.glb"), ErrorCode::kOutput);
    EXPECT_EQ(code(model, "none/a.gltf"), ErrorCode::kOutput);
    EXPECT_EQ(code(model, "a.glb", {.scale = 0.0}), ErrorCode::kInvalidOption);
    EXPECT_EQ(code(model, "a.glb", {.scale = NAN}), ErrorCode::kInvalidOption);
    TexturedMesh bad_image = model;
    bad_image.images[0].pixels.pop_back();
    EXPECT_EQ(code(bad_image, "a.glb"), ErrorCode::kInvalidInput);
    EXPECT_EQ(code(bad_image, "a.gltf"), ErrorCode::kInvalidInput);
    EXPECT_EQ(code(bad_image, "a.obj"), ErrorCode::kInvalidInput);
    EXPECT_EQ(code(bad_image, "a.ply"), ErrorCode::kInvalidInput);
}

TEST(Gltf, OneFileInTheWayKeepsTheOthersBack) {
    const Folder folder;
    std::filesystem::create_directory(folder / "a.png");  // where the page must go
    for (const char* name : {"a.gltf", "a.obj", "a.ply"}) {
        const auto thrown = error_of([&] { write_model(patch_grid(2, 1), folder / name); });
        ASSERT_TRUE(thrown) << name;
        EXPECT_EQ(thrown->code, ErrorCode::kOutput);
        EXPECT_THAT(folder.names(), ElementsAre("a.png")) << name;
    }
}

TEST(Gltf, StopsWhenCancelledAndLeavesNothing) {
    const Folder folder;
    const TexturedMesh model = patch_grid(20, 1);
    for (const char* name : {"a.glb", "b.gltf", "c.obj", "d.ply"}) {
        std::stop_source stop;
        const Context context{.stop = stop.get_token(),
                              .progress = [&](std::string_view stage, double) {
                                  EXPECT_EQ(stage, "write");
                                  stop.request_stop();
                              }};
        const auto thrown = error_of([&] { write_model(model, folder / name, {}, context); });
        ASSERT_TRUE(thrown) << name;
        EXPECT_EQ(thrown->code, ErrorCode::kCancelled) << name;
        EXPECT_THAT(folder.names(), IsEmpty()) << name;
    }
}

TEST(Gltf, ProgressRisesToOne) {
    const Folder folder;
    for (const char* name : {"a.glb", "b.gltf", "c.obj", "d.ply"}) {
        std::vector<double> fractions;
        const Context context{
            .progress = [&](std::string_view, double f) { fractions.push_back(f); }};
        write_model(patch_grid(4, 2), folder / name, {}, context);
        EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
        EXPECT_EQ(fractions.front(), 0.0);
        EXPECT_EQ(fractions.back(), 1.0);
    }
}

/// Every kind of file this writer makes, for the Khronos validator.
TEST(Gltf, PassesTheKhronosValidatorWithoutErrorOrWarning) {
    const Folder folder;
    std::vector<std::filesystem::path> files;
    const auto write = [&](const std::string& name, const TexturedMesh& model,
                           WriteOptions options = {}) {
        files.push_back(folder / name);
        write_model(model, files.back(), options);
    };
    write("one.glb", patch_grid(12, 1));
    write("pages.glb", patch_grid(12, 2));
    write("pages.gltf", patch_grid(12, 2));
    write("long.glb", patch_grid(110, 1));
    write("lit.glb", patch_grid(12, 1), {.shading = Shading::kLit});
    write("utm.glb", patch_grid(12, 1, {5e5, 5e6, 100.0}), {.up = UpAxis::kZ, .scale = 0.001});
    write("far.glb", patch_grid(12, 1, {4e6, 3e5, 4.9e6}));
    write("bare.glb", tetrahedron());
    TexturedMesh colored = tetrahedron();
    colored.mesh.colors.assign(4, Rgb16{65535, 30000, 0});
    write("colored.glb", colored, {.up = UpAxis::kX});
    TexturedMesh oregon = patch_grid(12, 1, {5e5, 5e6, 100.0});
    oregon.frame = kOregon;
    write("oregon.glb", oregon, {});
    TexturedMesh mapped = patch_grid(12, 1);
    mapped.images.push_back(fixtures::random_image(16, 16, 3, 4));
    mapped.materials[0].normal_image = 1;
    write("mapped.glb", mapped);
    mapped.materials[0].color_image = -1;
    write("normals.glb", mapped);
    for (int channels = 1; channels <= 4; ++channels) {
        TexturedMesh any = patch_grid(2, 1);
        any.images[0] = fixtures::random_image(8, 4, channels, 3);
        write("channels" + std::to_string(channels) + ".glb", any);
    }
    for (const auto& file : files) EXPECT_THAT(check_glb(file).problems, IsEmpty()) << file;

    const ValidatorResult result = run_gltf_validator(POINTBAKE_TEST_SUPPORT, files);
    if (!result.is_available)
        GTEST_SKIP() << "THE KHRONOS VALIDATOR DID NOT RUN: " << result.output
                     << "run 'npm ci' in tests/support";
    EXPECT_TRUE(result.is_clean) << result.output;
}

TEST(CheckGlb, SeesWhatIsWrong) {
    const Folder folder;
    write_model(patch_grid(2, 1), folder / "a.glb");
    const std::string good = read_text(folder / "a.glb");
    const auto with = [&](const std::string& from, const std::string& to) {
        std::string bad = good;
        bad.replace(bad.find(from), from.size(), to);
        fixtures::write_text(folder / "b.glb", bad);
        return check_glb(folder / "b.glb").problems.size();
    };
    EXPECT_EQ(with("pointbake", "pointbake"), 0U);
    EXPECT_GT(with("glTF", "glTG"), 0U);
    EXPECT_GT(with("\"2.0\"", "\"2.1\""), 0U);
    EXPECT_GT(with("\"min\":[0.0", "\"min\":[0.1"), 0U);
    EXPECT_GT(with("33071", "10497"), 0U);
    EXPECT_GT(with("KHR_materials_unlit", "KHR_materials_unlid"), 0U);
    EXPECT_GT(with("\x89PNG", "\x89PNK"), 0U);
    EXPECT_GT(with("\"componentType\":5123", "\"componentType\":5122"), 0U);
    fixtures::write_text(folder / "b.glb", good.substr(0, good.size() - 4));
    EXPECT_FALSE(check_glb(folder / "b.glb").problems.empty());
}

}  // namespace
}  // namespace pointbake
