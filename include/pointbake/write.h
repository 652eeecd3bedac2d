// Stage 7: the textured mesh becomes a file: GLB, glTF, OBJ, PLY. Written to a temporary file and
// renamed: whole or not at all.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/options.h"
#include "pointbake/types.h"

namespace pointbake {

enum class Shading { kUnlit, kLit };
template <>
struct EnumWords<Shading> {
    static constexpr std::string_view words[] = {"unlit", "lit"};
};

enum class Compression { kNone, kMeshopt, kDraco };
template <>
struct EnumWords<Compression> {
    static constexpr std::string_view words[] = {"none", "meshopt", "draco"};
};
enum class ImageFormat { kPng, kJpeg, kWebp };
template <>
struct EnumWords<ImageFormat> {
    static constexpr std::string_view words[] = {"png", "jpeg", "webp"};
};

/// How the pages of colours become image files.
struct ImageOptions {
    ImageFormat format = ImageFormat::kPng;
    int quality = 90;
    template <class Field>
    static void describe(Field&& field) {
        field("texture-format", &ImageOptions::format,
              "of colour maps; jpeg and webp are smaller, and what they lose counts as error");
        field("texture-quality", &ImageOptions::quality,
              "1 to 100, of jpeg and webp; webp loses nothing at 100");
    }
};

/// Throws Error{kInvalidOption} for a quality out of range.
void validate(const ImageOptions& options);

struct WriteOptions {
    Shading shading = Shading::kUnlit;
    UpAxis up = UpAxis::kAuto;
    std::optional<double> scale{};
    Compression compress = Compression::kNone;
    template <class Field>
    static void describe(Field&& field) {
        field("shading", &WriteOptions::shading,
              "unlit: colours as captured; lit: with normals, for a lit scene");
        field("up", &WriteOptions::up,
              "which axis of the input points up (a node transform; coordinates stay); auto: as "
              "its kind "
              "of file has it");
        field("scale", &WriteOptions::scale,
              "metres per unit of the input (a node transform; coordinates stay); default: as its "
              "CRS "
              "says, else 1");
        field("compress", &WriteOptions::compress,
              "of the geometry in GLB and glTF, for viewers that know the extension");
    }
};

struct WriteReport {
    std::uint64_t num_bytes = 0;       ///< all files together
    std::uint64_t num_vertices = 0;    ///< after splits along texture borders
    std::uint64_t num_draw_calls = 0;  ///< primitives
    Frame frame;                       ///< what the input tells, or options overrule
    Vec3d global_shift;  ///< what a node translation carries, as floats would lose it; else zero
    bool has_transform = false;    ///< the frame is a transform in the file
    bool has_translation = false;  ///< so is the shift
    std::filesystem::path prj;     ///< the CRS beside the output; empty = none
    std::vector<std::filesystem::path> files;
};

/// The input's frame, where options do not overrule it.
Frame settled_frame(Frame frame, const WriteOptions& options);

/// Writes by extension: .glb, .gltf (+ .bin, .png), .obj (+ .mtl, .png), .ply (texture coordinates
/// per face, or vertex colours). glTF passes the Khronos validator with 0 errors and 0 warnings:
/// normals only where lit, samplers that clamp (repeat where a page does) and use mip levels only
/// where a page has them, exact accessor bounds. Coordinates that lose more than 1e-6 of the
/// diagonal as floats are written relative to a node translation. The model's frame turns and
/// scales a glTF's node, and is told in its extras and in comments of OBJ and PLY; a CRS that is
/// known goes into a .prj beside the model, unless another one is there already (a warning). Throws
/// Error{kOutput} and leaves nothing behind, also where a part of the output (an image, .mtl, .bin)
/// would overwrite a file though the output itself is not there yet; Error{kUnsupported} names the
/// extensions that are known.
WriteReport write_model(const TexturedMesh& model, const std::filesystem::path& path,
                        const WriteOptions& options = {}, const Context& context = {});

/// Writes points as binary little-endian PLY, doubles where the coordinates need them, with every
/// attribute and channel, and a .prj like write_model.
WriteReport write_cloud(const PointCloud& cloud, const std::filesystem::path& path,
                        const Context& context = {});

/// Writes every input row: coordinates, row, kept (0 or 1), reason; points that `off_surface` marks
/// are not kept.
void write_points(const PointCloud& cloud, std::span<const std::uint8_t> off_surface,
                  const std::filesystem::path& path, const Context& context = {});

/// Writes an image as 8-bit PNG.
void write_png(const Image& image, const std::filesystem::path& path, const Context& context = {});

}  // namespace pointbake
