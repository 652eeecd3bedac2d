// What the mesh readers share: materials with their images, and a mesh with each position once.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Makes vertices of equal positions one (the lowest), drops triangles without three different
/// corners, then vertices that no triangle uses. Colours of merged vertices are averaged in linear
/// light. Texture coordinates belong to corners and stay. Throws Error{kInvalidInput} naming `name`
/// for coordinates that are not finite.
void weld_in_place(TexturedMesh& mesh, const std::string& name);

/// Clean-up that ends every reader: welds, leaves out texture coordinates and material numbers that
/// say nothing, makes sure that there is a material. Throws Error{kEmpty} naming `name` if no
/// triangle is left.
TexturedMesh finish_mesh(TexturedMesh mesh, const std::string& name);

/// Reads each image file once. A missing one is a warning: the mesh can be used without.
class TextureFiles {
 public:
    TextureFiles(std::filesystem::path folder, const Context& context)
        : folder_(std::move(folder)), context_(context) {}

    /// Index into mesh.images; -1 if the file is not there. Backslashes count as slashes.
    int load(std::string name, TexturedMesh& mesh);

 private:
    std::filesystem::path folder_;
    const Context& context_;
    std::map<std::string, int> images_;
};

}  // namespace pointbake
