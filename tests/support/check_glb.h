// Reads GLB and glTF files as a stranger would and checks what the specification demands of them.
// Shares no code with the writer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pointbake/vec.h"

namespace pointbake {

/// A primitive with its accessors decoded; positions are in the scene (node transforms applied in
/// double), uvs, normals, tangents and colours as stored, empty if absent.
struct GlbPrimitive {
    std::vector<Vec3d> positions;
    std::vector<Vec3f> stored_positions;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<Vec2f> uvs;
    std::vector<Vec3f> normals;
    std::vector<std::array<float, 4>> tangents;
    std::vector<std::array<std::uint16_t, 4>> colors;
    int index_bytes = 0;
    std::size_t material = 0;
};

struct GlbContents {
    /// What is wrong with the file, one line each; empty = nothing.
    std::vector<std::string> problems;
    nlohmann::json document;
    std::vector<GlbPrimitive> primitives;
    std::vector<std::vector<std::byte>> images;  ///< PNG bytes
};

/// Reads and checks .glb or .gltf: chunks, lengths and alignment, index and byte ranges of every
/// reference, strides, targets, exact accessor bounds, finite values, unit normals and tangents,
/// indices in range and no repeated corner, image signatures, samplers, node transforms, and that
/// nothing is left unused. Never throws for a bad file: problems says what is wrong.
GlbContents check_glb(const std::filesystem::path& path);

/// What an independent program says of some files.
struct ValidatorResult {
    bool is_available = false;  ///< it and what it needs are there
    bool is_clean = false;      ///< no error, no warning
    std::string output;         ///< its summary, or why it cannot run
};

/// Runs validate_gltf.mjs of `script_folder` on the files.
ValidatorResult run_gltf_validator(const std::filesystem::path& script_folder,
                                   const std::vector<std::filesystem::path>& files);

/// Runs check_models.py of `script_folder`, which reads the files with "usd", "open3d" or
/// "trimesh". POINTBAKE_PYTHON names the Python that has them; else it is python3.
ValidatorResult run_reader(const std::filesystem::path& script_folder, const std::string& reader,
                           const std::vector<std::filesystem::path>& files);

}  // namespace pointbake
