#include "write/file_set.h"

#include <system_error>

#include "core/message.h"

namespace pointbake {

AtomicFile& FileSet::add(const std::filesystem::path& path) {
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
        for (std::size_t i = next + 1; i < files_.size(); ++i) {
            std::error_code ignored;
            // Never a device, which was written directly.
            if (std::filesystem::is_regular_file(paths_[i], ignored))
                std::filesystem::remove(paths_[i], ignored);
        }
        throw;
    }
}

std::filesystem::path sibling(const std::filesystem::path& main, std::string_view suffix) {
    return main.parent_path() / (main.stem().string() + std::string(suffix));
}

std::vector<std::filesystem::path> image_paths(const std::filesystem::path& main,
                                               std::size_t num_images) {
    std::vector<std::filesystem::path> paths;
    for (std::size_t i = 0; i < num_images; ++i)
        paths.push_back(sibling(main, num_images == 1 ? ".png" : fmt::format("_{}.png", i)));
    return paths;
}

}  // namespace pointbake
