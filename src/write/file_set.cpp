#include "write/file_set.h"

#include "core/message.h"
#include "write/encode_image.h"

namespace pointbake {

AtomicFile& FileSet::add(const std::filesystem::path& path) {
    if (!paths_.empty()) check_is_no_stranger(paths_[0], path);
    files_.push_back(std::make_unique<AtomicFile>(path));
    paths_.push_back(path);
    return *files_.back();
}

void FileSet::commit(WriteReport& report) {
    report.files = paths_;
    for (const auto& file : files_) report.num_bytes += file->size();
    std::size_t next = files_.size();
    try {
        while (next > 0) files_[--next]->commit();
    } catch (...) {
        while (++next < files_.size()) files_[next]->undo();
        throw;
    }
}

std::filesystem::path sibling(const std::filesystem::path& main, std::string_view suffix) {
    return main.parent_path() / (main.stem().string() + std::string(suffix));
}

std::vector<std::filesystem::path> image_paths(const std::filesystem::path& main,
                                               const TexturedMesh& model,
                                               std::span<const int> images) {
    std::vector<std::filesystem::path> paths;
    for (std::size_t i = 0; i < images.size(); ++i) {
        const Image& image = model.images[static_cast<std::size_t>(images[i])];
        const std::string number = images.size() == 1 ? "" : fmt::format("_{}", i);
        paths.push_back(sibling(main, fmt::format("{}{}", number, file_kind(image).extension)));
    }
    return paths;
}

}  // namespace pointbake
