#include "files.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <sstream>
#include <vector>

#include "core/atomic_file.h"
#include "core/message.h"

namespace pointbake::cli {
namespace {

namespace fs = std::filesystem;

// Longer headers exist only in broken files.
constexpr std::size_t kLongestHeader = 1 << 16;

/// The header of a PLY file as text, up to end_header; empty for anything else.
std::string ply_header(const fs::path& path) {
    std::error_code error;
    if (!fs::is_regular_file(path, error)) return {};
    std::ifstream file(path, std::ios::binary);
    std::string text(kLongestHeader, '\0');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
    const std::size_t end = text.find("end_header");
    return text.starts_with("ply") && end != std::string::npos ? text.substr(0, end) : "";
}

/// The count of an element in a PLY header.
std::optional<std::uint64_t> element_count(const std::string& header, std::string_view name) {
    std::istringstream lines(header);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string keyword, element;
        std::uint64_t count = 0;
        if (words >> keyword >> element >> count && keyword == "element" && element == name)
            return count;
    }
    return std::nullopt;
}

}  // namespace

std::string lower_extension(const fs::path& path) {
    std::string extension = path.extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

bool is_packed(const fs::path& path) {
    const std::string extension = lower_extension(path);
    return extension == ".gz" || extension == ".zst";
}

void check_writable(const fs::path& output, std::span<const fs::path> inputs) {
    std::error_code error;
    for (const fs::path& input : inputs)
        if (fs::equivalent(input, output, error))
            fail(ErrorCode::kInvalidOption, "{} is an input; it would be overwritten",
                 output.string());
    if (fs::is_directory(output, error))
        fail(ErrorCode::kOutput, "{} is a directory; expected a file name", output.string());
    const AtomicFile probe(output);
}

void check_extension(const fs::path& output, std::span<const std::string_view> extensions) {
    if (std::ranges::find(extensions, lower_extension(output)) != extensions.end()) return;
    fail(ErrorCode::kInvalidOption, "{}: the name of the output must end in {}", output.string(),
         fmt::join(extensions, ", "));
}

namespace {

bool has_companions(const fs::path& path) {
    const std::string extension = lower_extension(path);
    return extension == ".obj" || extension == ".gltf";
}

fs::path folder(const fs::path& path) {
    return fs::absolute(path).lexically_normal().parent_path();
}

/// Whether a text file holds a word.
bool mentions(const fs::path& path, const std::string& word) {
    std::ifstream file(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    return text.find(word) != std::string::npos;
}

}  // namespace

void check_no_texture(const fs::path& output, std::span<const fs::path> inputs) {
    std::error_code error;
    if (!fs::exists(output, error)) return;
    const fs::path target = fs::weakly_canonical(output, error);
    const std::string name = target.filename().string();
    for (const fs::path& input : inputs) {
        if (!has_companions(input)) continue;
        bool is_named = lower_extension(input) == ".gltf" && mentions(input, name);
        for (const auto& entry : fs::directory_iterator(folder(input), error))
            is_named = is_named ||
                       (lower_extension(entry.path()) == ".mtl" && mentions(entry.path(), name));
        if (is_named)
            fail(ErrorCode::kInvalidOption, "{} is a texture of {}; choose another name",
                 output.string(), input.string());
    }
}

void check_companions(const fs::path& output, std::span<const fs::path> inputs) {
    if (!has_companions(output)) return;
    for (const fs::path& input : inputs)
        if (has_companions(input) && input.stem() == output.stem() &&
            folder(input) == folder(output))
            fail(ErrorCode::kInvalidOption,
                 "{} would share its textures and other files with the input {}; choose another "
                 "name",
                 output.string(), input.string());
}

void check_no_strangers(const fs::path& output, std::string_view image_extension) {
    const std::string extension = lower_extension(output);
    if (extension == ".obj") check_is_no_stranger(output, beside(output, ".mtl"));
    if (extension == ".gltf") check_is_no_stranger(output, beside(output, ".bin"));
    if ((has_companions(output) || extension == ".ply") && !image_extension.empty())
        check_is_no_stranger(output, beside(output, image_extension));
}

fs::path beside(const fs::path& file, std::string_view ending) {
    return file.parent_path() / fmt::format("{}{}", file.stem().string(), ending);
}

void write_text(const fs::path& path, std::string_view text) {
    AtomicFile file(path);
    file.write(text);
    file.commit();
}

bool is_likely_input(const fs::path& path) {
    std::error_code error;
    const std::string extension = lower_extension(path);
    if (std::ranges::find(kMeshExtensions, extension) == kMeshExtensions.end())
        return fs::is_regular_file(path, error);
    const std::string header = ply_header(path);
    if (header.empty()) return false;
    const bool has_faces = element_count(header, "face").value_or(0) > 0 ||
                           element_count(header, "tristrips").value_or(0) > 0;
    return !has_faces || header.find("comment pointbake ") == std::string::npos;
}

}  // namespace pointbake::cli
