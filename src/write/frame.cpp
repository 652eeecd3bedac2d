#include "write/frame.h"

#include <fstream>
#include <iterator>

#include "core/message.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

/// A name as one line has room for it.
std::string one_line(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < ' ') c = ' ';
    return text;
}

std::string file_text(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void add_prj(FileSet& files, const std::filesystem::path& main, WriteReport& report,
             const Context& context) {
    const Frame& frame = report.frame;
    if (frame.crs.wkt.empty()) return;
    const std::filesystem::path path = sibling(main, ".prj");
    const std::string text = frame.crs.wkt + "\n";
    std::error_code ignored;
    if (std::filesystem::exists(path, ignored)) {
        if (file_text(path) == text)
            report.prj = path;
        else
            log(context, LogLevel::kWarning,
                "{} is there already and says something else than {}: left as it is", path.string(),
                frame.crs.name);
        return;
    }
    files.add(path).write(text);
    report.prj = path;
}

}  // namespace

Frame settled_frame(Frame frame, const WriteOptions& options) {
    if (options.up != UpAxis::kAuto) frame.up = options.up;
    if (options.scale) frame.metres_per_unit = *options.scale;
    return frame;
}

std::string frame_text(const Frame& frame) {
    std::vector<std::string> facts;
    if (frame.metres_per_unit != 0.0)
        facts.push_back(fmt::format("unit {} m", frame.metres_per_unit));
    if (frame.up != UpAxis::kAuto) facts.push_back(fmt::format("{} up", to_word(frame.up)));
    if (!frame.crs.name.empty()) facts.push_back(one_line(frame.crs.name));
    if (frame.crs.epsg != 0) facts.push_back(fmt::format("EPSG:{}", frame.crs.epsg));
    return fmt::format("{}", fmt::join(facts, ", "));
}

void commit_with_prj(FileSet& files, const std::filesystem::path& main, WriteReport& report,
                     const Context& context) {
    add_prj(files, main, report, context);
    check_cancelled(context);
    files.commit(report);
}

}  // namespace pointbake
