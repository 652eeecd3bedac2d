// Several files that are there together or not at all.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "core/atomic_file.h"
#include "pointbake/write.h"

namespace pointbake {

/// Files of one output. They are committed together; if that fails half-way, all is as it was.
class FileSet {
 public:
    /// A new file; the first one added is the main one, which is committed last. Throws
    /// Error{kOutput} if another one is there though the main one is not: it is somebody else's.
    AtomicFile& add(const std::filesystem::path& path);
    /// Puts all files in place and fills the report's num_bytes and files.
    void commit(WriteReport& report);

 private:
    std::vector<std::filesystem::path> paths_;
    std::vector<std::unique_ptr<AtomicFile>> files_;
};

/// The path of a file beside `main`: its stem, then `suffix`.
std::filesystem::path sibling(const std::filesystem::path& main, std::string_view suffix);

/// Names of those of a model's images that are in use, beside `main`: stem.png, or stem_0.png,
/// stem_1.png, ...; .jpg and .webp of those that are such files.
std::vector<std::filesystem::path> image_paths(const std::filesystem::path& main,
                                               const TexturedMesh& model,
                                               std::span<const int> images);

}  // namespace pointbake
