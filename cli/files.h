// Looking at files before the long work: may the output be written, would it overwrite an input.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/message.h"

namespace pointbake::cli {

/// Throws Error{kOutput} if a file cannot be made there, Error{kInvalidOption} if it is an input.
/// Leaves nothing behind.
void check_writable(const std::filesystem::path& output,
                    std::span<const std::filesystem::path> inputs);

/// What a mesh is written as.
inline constexpr std::array<std::string_view, 6> kMeshExtensions = {".glb", ".gltf", ".obj",
                                                                    ".ply", ".stl",  ".usdz"};

/// Throws Error{kInvalidOption} unless the name ends in one of the extensions (".glb", ...).
void check_extension(const std::filesystem::path& output,
                     std::span<const std::string_view> extensions);

/// Throws Error{kInvalidOption} if a model of several files would overwrite what an input of the
/// same name consists of: x.obj beside x.gltf, both with their x.png.
void check_companions(const std::filesystem::path& output,
                      std::span<const std::filesystem::path> inputs);

/// check_is_no_stranger() for the parts that are known before the work: x.mtl, x.bin, x.png
/// (`image_extension`; empty = no textures).
void check_no_strangers(const std::filesystem::path& output, std::string_view image_extension);

/// ".png" of "a/B.PNG".
std::string lower_extension(const std::filesystem::path& path);

/// Whether the name says that the file is packed: .gz, .zst.
bool is_packed(const std::filesystem::path& path);

/// Throws Error{kInvalidOption} if `output` is a file that an OBJ or glTF input in the same folder
/// names: one of its textures.
void check_no_texture(const std::filesystem::path& output,
                      std::span<const std::filesystem::path> inputs);

/// Calls what works on the points of a file. Errors about the points say which file it is.
template <class Work>
auto naming(std::string_view input, Work&& work) {
    try {
        return work();
    } catch (const Error& error) {
        const bool is_about_points = error.code() == ErrorCode::kDegenerate ||
                                     error.code() == ErrorCode::kInvalidInput ||
                                     error.code() == ErrorCode::kEmpty;
        if (!is_about_points) throw;
        fail(error.code(), "{}: {}", input, error.what());
    }
}

/// "dir/name.ext" and an ending make "dir/name<ending>".
std::filesystem::path beside(const std::filesystem::path& file, std::string_view ending);

/// Writes a text whole or not at all.
void write_text(const std::filesystem::path& path, std::string_view text);

/// Whether an existing file is of no kind that is written, a PLY of points alone, or a PLY that
/// pointbake did not write.
/// Overwriting such a one is likelier a slip than a wish.
bool is_likely_input(const std::filesystem::path& path);

}  // namespace pointbake::cli
