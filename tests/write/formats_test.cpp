// Images beside PNG, and the formats STL and USDZ.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "io/image_io.h"
#include "pointbake/write.h"
#include "support/check_glb.h"
#include "write/encode_image.h"
#include "write/write_fixtures.h"

namespace pointbake {
namespace {

using fixtures::error_of;
using fixtures::Folder;
using fixtures::patch_grid;
using fixtures::read_text;
using fixtures::tetrahedron;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::string text_of(const std::vector<std::byte>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Red stripes of one texel on blue: chroma without resolution would make it violet.
Image stripes() {
    Image image{.width = 64, .height = 32, .num_channels = 3, .pixels = {}};
    for (int i = 0; i < 64 * 32; ++i)
        for (const int v : {i % 2 == 0 ? 220 : 30, 30, i % 2 == 0 ? 30 : 220})
            image.pixels.push_back(static_cast<std::uint8_t>(v));
    return image;
}

double largest_error(const Image& image, const ImageOptions& options) {
    const Image read = decode_image(encode_lossy(image, options), "test");
    double worst = 0.0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        worst = std::max(worst, std::fabs(static_cast<double>(image.pixels[i] - read.pixels[i])));
    return worst;
}

TEST(EncodeImage, JpegKeepsChromaFromQuality90On) {
    EXPECT_LT(largest_error(stripes(), {ImageFormat::kJpeg, 90}), 40.0);
    EXPECT_GT(largest_error(stripes(), {ImageFormat::kJpeg, 89}), 80.0);
}

TEST(EncodeImage, WebpLosesNothingAt100) {
    const Image image = fixtures::random_image(50, 40, 3, 5);
    EXPECT_EQ(largest_error(image, {ImageFormat::kWebp, 100}), 0.0);
    EXPECT_GT(largest_error(image, {ImageFormat::kWebp, 99}), 0.0);
}

TEST(EncodeImage, LowerQualityIsSmaller) {
    const Image image = fixtures::random_image(64, 64, 3, 5);
    for (const ImageFormat format : {ImageFormat::kJpeg, ImageFormat::kWebp})
        EXPECT_LT(encode_lossy(image, {format, 30}).size(),
                  encode_lossy(image, {format, 80}).size());
}

TEST(EncodeImage, RefusesWhatTheFormatCannotHold) {
    Image image{.width = 16400, .height = 1, .num_channels = 3, .pixels = {}};
    image.pixels.resize(3 * image.num_texels());
    const auto thrown = error_of([&] { encode_lossy(image, {ImageFormat::kWebp, 90}); });
    ASSERT_TRUE(thrown);
    EXPECT_EQ(thrown->code, ErrorCode::kLimit);
    EXPECT_THAT(thrown->message, HasSubstr("16383"));
    EXPECT_FALSE(encode_lossy(image, {ImageFormat::kJpeg, 90}).empty());
    for (const int quality : {0, 101})
        EXPECT_EQ(error_of([&] { validate(ImageOptions{ImageFormat::kJpeg, quality}); })->code,
                  ErrorCode::kInvalidOption);
}

TEST(EncodeImage, StopsWhenToldTo) {
    std::stop_source stop;
    stop.request_stop();
    Context context;
    context.stop = stop.get_token();
    const auto thrown =
        error_of([&] { encode_lossy(stripes(), {ImageFormat::kWebp, 90}, context); });
    ASSERT_TRUE(thrown);
    EXPECT_EQ(thrown->code, ErrorCode::kCancelled);
}

TexturedMesh coded_grid(ImageFormat format) {
    TexturedMesh model = patch_grid(6, 2);
    for (Image& image : model.images) image.file = encode_lossy(image, {format, 80});
    return model;
}

TEST(CodedPages, AreWrittenAsTheyAre) {
    for (const auto& [format, extension, mime] :
         {std::tuple{ImageFormat::kJpeg, ".jpg", "image/jpeg"},
          std::tuple{ImageFormat::kWebp, ".webp", "image/webp"}}) {
        const Folder folder;
        const TexturedMesh model = coded_grid(format);
        for (const char* name : {"a.gltf", "b.obj", "c.ply"}) {
            write_model(model, folder / name);
            for (std::size_t i = 0; i < 2; ++i)
                EXPECT_EQ(read_text(folder / fmt::format("{}_{}{}", name[0], i, extension)),
                          text_of(model.images[i].file));
        }
        EXPECT_THAT(read_text(folder / "b.mtl"), HasSubstr(fmt::format("map_Kd b_1{}", extension)));
        EXPECT_THAT(read_text(folder / "c.ply"),
                    HasSubstr(fmt::format("comment TextureFile c_1{}", extension)));
        write_model(model, folder / "d.glb");
        const std::string glb = read_text(folder / "d.glb");
        EXPECT_THAT(glb, HasSubstr(text_of(model.images[1].file)));
        EXPECT_THAT(glb, HasSubstr(fmt::format("\"mimeType\":\"{}\"", mime)));
    }
}

TEST(CodedPages, WebpInGltfIsAnExtensionThatReadersMustKnow) {
    const Folder folder;
    write_model(coded_grid(ImageFormat::kWebp), folder / "a.glb");
    EXPECT_THAT(read_text(folder / "a.glb"),
                testing::AllOf(HasSubstr("\"extensionsRequired\":[\"EXT_texture_webp\"]"),
                               HasSubstr("{\"EXT_texture_webp\":{\"source\":1}}")));
    write_model(coded_grid(ImageFormat::kJpeg), folder / "b.glb");
    EXPECT_THAT(read_text(folder / "b.glb"), Not(HasSubstr("EXT_texture_webp")));
    const ValidatorResult result =
        run_gltf_validator(POINTBAKE_TEST_SUPPORT, {folder / "a.glb", folder / "b.glb"});
    if (!result.is_available)
        GTEST_SKIP() << "THE KHRONOS VALIDATOR DID NOT RUN: " << result.output
                     << "run 'npm ci' in tests/support";
    EXPECT_TRUE(result.is_clean) << result.output;
}

TEST(Stl, HoldsTheTrianglesAndTheirNormals) {
    const Folder folder;
    const TexturedMesh model = patch_grid(5, 2);
    const WriteReport report = write_model(model, folder / "a.stl");
    EXPECT_THAT(folder.names(), ElementsAre("a.stl"));
    const std::string bytes = read_text(folder / "a.stl");
    ASSERT_EQ(bytes.size(), 84 + 50 * model.mesh.triangles.size());
    EXPECT_EQ(report.num_bytes, bytes.size());
    EXPECT_THAT(bytes, Not(testing::StartsWith("solid")));
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, 4);
    EXPECT_EQ(count, model.mesh.triangles.size());
    for (std::size_t t = 0; t < count; ++t) {
        std::array<Vec3f, 4> row;  // normal and corners
        std::memcpy(&row, bytes.data() + 84 + 50 * t, sizeof row);
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_EQ(row[k + 1],
                      vec_cast<float>(model.mesh.positions[model.mesh.triangles[t][k]]));
        EXPECT_NEAR(length(row[0]), 1.0F, 1e-6F);
        EXPECT_NEAR(dot(row[0], row[2] - row[1]), 0.0F, 1e-6F);
        EXPECT_GT(dot(row[0], cross(row[2] - row[1], row[3] - row[1])), 0.0F);
    }
}

TEST(Stl, SaysWhatWasTakenOffLargeCoordinates) {
    const Folder folder;
    std::string warning;
    Context context;
    context.log = [&](LogLevel, std::string_view text) { warning = text; };
    const WriteReport report =
        write_model(patch_grid(3, 1, {5e5, 5e6, 0.0}, 0.01), folder / "a.stl", {}, context);
    EXPECT_NE(report.global_shift, Vec3d{});
    EXPECT_THAT(warning, HasSubstr("relative to"));
}

/// Name, first byte and content of each file of a stored archive.
struct Stored {
    std::string name;
    std::size_t offset = 0;
    std::string bytes;
};
std::vector<Stored> unzip(const std::string& zip) {
    std::vector<Stored> out;
    const auto number = [&](std::size_t at, int bytes) {
        std::size_t v = 0;
        for (int i = bytes - 1; i >= 0; --i)
            v = v << 8U | static_cast<unsigned char>(zip[at + static_cast<std::size_t>(i)]);
        return v;
    };
    for (std::size_t at = 0; zip.substr(at, 4) == "PK\x03\x04";) {
        const std::size_t size = number(at + 18, 4), name = number(at + 26, 2),
                          extra = number(at + 28, 2);
        const std::size_t begin = at + 30 + name + extra;
        out.push_back({zip.substr(at + 30, name), begin, zip.substr(begin, size)});
        at = begin + size;
    }
    return out;
}

TEST(Usdz, IsAnAlignedArchiveOfTextAndImages) {
    const Folder folder;
    const TexturedMesh model = coded_grid(ImageFormat::kJpeg);
    write_model(model, folder / "a.usdz");
    const std::vector<Stored> files = unzip(read_text(folder / "a.usdz"));
    ASSERT_EQ(files.size(), 3U);
    EXPECT_EQ(files[0].name, "model.usda");
    EXPECT_EQ(files[1].name, "textures/0.jpg");
    for (const Stored& file : files) EXPECT_EQ(file.offset % 64, 0U) << file.name;
    EXPECT_EQ(files[2].bytes, text_of(model.images[1].file));
    EXPECT_THAT(files[0].bytes, testing::StartsWith("#usda 1.0\n"));
    EXPECT_THAT(files[0].bytes, HasSubstr("inputs:emissiveColor.connect"));
    EXPECT_THAT(files[0].bytes, Not(HasSubstr("inputs:diffuseColor.connect")));
    write_model(model, folder / "lit.usdz", {.shading = Shading::kLit});
    EXPECT_THAT(unzip(read_text(folder / "lit.usdz"))[0].bytes,
                HasSubstr("inputs:diffuseColor.connect"));
}

TEST(Usdz, RefusesWebp) {
    const Folder folder;
    const auto thrown =
        error_of([&] { write_model(coded_grid(ImageFormat::kWebp), folder / "a.usdz"); });
    ASSERT_TRUE(thrown);
    EXPECT_EQ(thrown->code, ErrorCode::kUnsupported);
    EXPECT_THAT(thrown->message, HasSubstr("--texture-format jpeg"));
    EXPECT_TRUE(folder.names().empty());
}

/// A model of every kind.
std::vector<TexturedMesh> all_kinds() {
    std::vector<TexturedMesh> models = {patch_grid(6, 2), coded_grid(ImageFormat::kJpeg),
                                        tetrahedron(), tetrahedron(), patch_grid(4, 1)};
    models[3].mesh.colors.assign(4, Rgb16{65535, 30000, 0});
    models[4].images.push_back(fixtures::random_image(16, 16, 3, 4));
    models[4].materials[0].normal_image = 1;
    models[4].materials[0].is_double_sided = true;
    return models;
}

void expect_read(const char* reader, const std::vector<std::string>& extensions) {
    const Folder folder;
    std::vector<std::filesystem::path> files;
    std::vector<std::string> counts;
    for (const TexturedMesh& model : all_kinds())
        for (const std::string& extension : extensions) {
            files.push_back(folder / fmt::format("{}{}", files.size(), extension));
            write_model(model, files.back(), {.up = UpAxis::kZ, .scale = 0.01});
            counts.push_back(fmt::format(" {} ", model.mesh.triangles.size()));
        }
    const ValidatorResult result = run_reader(POINTBAKE_TEST_SUPPORT, reader, files);
    if (!result.is_available)
        GTEST_SKIP() << "THE READER " << reader << " DID NOT RUN: " << result.output
                     << "POINTBAKE_PYTHON may name a Python that has it";
    EXPECT_TRUE(result.is_clean) << result.output;
    std::istringstream lines(result.output);
    std::string line;
    for (std::size_t i = 0; i < files.size(); ++i) {
        while (std::getline(lines, line) && !line.starts_with(files[i].filename().string() + " ")) {
        }
        EXPECT_THAT(line, HasSubstr(counts[i])) << result.output;
    }
}

TEST(Readers, UsdFindsNoFault) { expect_read("usd", {".usdz"}); }
TEST(Readers, Open3dReadsAllButUsd) { expect_read("open3d", {".glb", ".obj", ".ply", ".stl"}); }
TEST(Readers, TrimeshReadsAllButUsd) { expect_read("trimesh", {".glb", ".obj", ".ply", ".stl"}); }

}  // namespace
}  // namespace pointbake
