// Folders, images and meshes for the tests of the writers.
#pragma once

#include <gtest/gtest.h>
#include <spng.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/hash.h"
#include "pointbake/error.h"
#include "pointbake/types.h"

namespace pointbake::fixtures {

namespace fs = std::filesystem;

/// A folder of its own for each test, removed at the end.
class Folder {
 public:
    Folder() {
        const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
        path_ = fs::temp_directory_path() / ("pointbake-" + std::to_string(::getpid()) + "-" +
                                             test->test_suite_name() + "-" + test->name());
        fs::create_directories(path_);
    }
    ~Folder() {
        std::error_code ignored;
        fs::permissions(path_, fs::perms::owner_all, ignored);
        fs::remove_all(path_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    fs::path operator/(const std::string& name) const { return path_ / name; }
    const fs::path& path() const { return path_; }
    /// Names of all there is.
    std::set<std::string> names() const {
        std::set<std::string> out;
        for (const auto& entry : fs::directory_iterator(path_))
            out.insert(entry.path().filename().string());
        return out;
    }

 private:
    fs::path path_;
};

inline std::string read_text(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

inline void write_text(const fs::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

/// The code of the Error that a call throws, and its message.
struct Thrown {
    ErrorCode code;
    std::string message;
};
template <class Call>
std::optional<Thrown> error_of(Call&& call) {
    try {
        call();
    } catch (const Error& e) {
        return Thrown{e.code(), e.what()};
    }
    return std::nullopt;
}

/// Decodes a PNG with libspng as it is stored: 8 bits, any number of channels.
inline Image decode_png(const void* bytes, std::size_t num_bytes) {
    const std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)> spng(spng_ctx_new(0), &spng_ctx_free);
    spng_set_crc_action(spng.get(), SPNG_CRC_ERROR, SPNG_CRC_ERROR);
    spng_set_png_buffer(spng.get(), bytes, num_bytes);
    spng_ihdr header{};
    EXPECT_EQ(spng_get_ihdr(spng.get(), &header), 0);
    EXPECT_EQ(header.bit_depth, 8);
    std::size_t size = 0;
    EXPECT_EQ(spng_decoded_image_size(spng.get(), SPNG_FMT_PNG, &size), 0);
    Image image{.width = static_cast<int>(header.width),
                .height = static_cast<int>(header.height),
                .num_channels = 0,
                .pixels = std::vector<std::uint8_t>(size)};
    EXPECT_EQ(spng_decode_image(spng.get(), image.pixels.data(), size, SPNG_FMT_PNG, 0), 0);
    if (image.num_texels() > 0) image.num_channels = static_cast<int>(size / image.num_texels());
    return image;
}

inline Image random_image(int width, int height, int num_channels, std::uint64_t seed) {
    Image image{.width = width, .height = height, .num_channels = num_channels, .pixels = {}};
    image.pixels.resize(image.num_texels() * static_cast<std::size_t>(num_channels));
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = static_cast<std::uint8_t>(hash64(seed, i));
    return image;
}

/// A wavy grid of 2 * cells^2 triangles. Every triangle has texture coordinates of its own; the
/// right half is on a second page if there are two.
inline TexturedMesh patch_grid(Index cells, std::size_t num_pages, Vec3d origin = {},
                               double cell = 1.0) {
    TexturedMesh model;
    for (Index y = 0; y <= cells; ++y)
        for (Index x = 0; x <= cells; ++x)
            model.mesh.positions.push_back(
                origin + Vec3d{x * cell, y * cell, 0.37 * cell * random_unit(3, x * 1000 + y)});
    for (Index i = 0; i < cells * cells; ++i) {
        const Index a = i / cells * (cells + 1) + i % cells, b = a + cells + 1;
        model.mesh.triangles.push_back({a, a + 1, b + 1});
        model.mesh.triangles.push_back({a, b + 1, b});
        for (int k = 0; k < 2; ++k)
            model.triangle_materials.push_back(num_pages > 1 && i % cells >= cells / 2 ? 1 : 0);
    }
    for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t) {
        const auto u = static_cast<float>(0.9 * random_unit(1, t));
        const auto v = static_cast<float>(0.9 * random_unit(2, t));
        model.mesh.uvs.push_back({Vec2f{u, v}, Vec2f{u + 0.1F, v}, Vec2f{u, v + 0.1F}});
    }
    for (std::size_t p = 0; p < num_pages; ++p) {
        model.materials.push_back(
            {.name = "page " + std::to_string(p), .color_image = static_cast<int>(p)});
        model.images.push_back(random_image(64, 32, 3, p));
    }
    return model;
}

/// A closed tetrahedron without any attribute.
inline TexturedMesh tetrahedron() {
    TexturedMesh model;
    model.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    model.mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    return model;
}

}  // namespace pointbake::fixtures
