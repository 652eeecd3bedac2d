#include "frame_lines.h"

#include <algorithm>

#include "console.h"
#include "core/message.h"

namespace pointbake::cli {
namespace {

/// Of files that hold coordinates alone no option changes these.
std::string overrules(const RunReport& r, bool is_asked, std::string_view option) {
    if (!r.write.has_transform) return "";
    return is_asked ? fmt::format(" (as {} says)", option) : fmt::format(" ({} overrules)", option);
}

std::string axes_line(const RunReport& r) {
    const UpAxis up = r.write.frame.up;
    if (up == UpAxis::kAuto) return "axes: up not told: taken for y (--up turns it)";
    return fmt::format("axes: {} up: {}{}", to_word(up),
                       !r.write.has_transform ? "coordinates stay as they are"
                       : up == UpAxis::kY     ? "as glTF has it"
                                              : "turned to y up by the node",
                       overrules(r, up != r.frame.up, "--up"));
}

std::string units_line(const RunReport& r) {
    const Frame& frame = r.write.frame;
    const bool is_asked = frame.metres_per_unit != r.frame.metres_per_unit;
    return fmt::format("units: {} of {:.10g} m: {}{}",
                       is_asked || frame.unit.empty() ? "unit" : frame.unit, frame.metres_per_unit,
                       r.write.has_transform ? "scaled to metres by the node" : "coordinates stay",
                       overrules(r, is_asked, "--scale"));
}

std::string crs_text(const Crs& crs) {
    return fmt::format("{}{}{}", crs.name, crs.epsg != 0 ? fmt::format(" (EPSG:{})", crs.epsg) : "",
                       crs.vertical.empty() ? "" : fmt::format(", heights {}", crs.vertical));
}

std::string crs_line(const RunReport& r) {
    const Crs& crs = r.write.frame.crs;
    return fmt::format("CRS: {}: {}", crs_text(crs),
                       !r.write.prj.empty() ? "in " + r.write.prj.string()
                       : crs.wkt.empty()    ? "no .prj, as the file names it without defining it"
                                            : "no .prj written");
}

}  // namespace

std::vector<std::string> frame_lines(const RunReport& r) {
    std::vector<std::string> lines;
    const Frame& frame = r.write.frame;
    if (frame.up != UpAxis::kAuto || r.write.has_transform) lines.push_back(axes_line(r));
    if (frame.metres_per_unit != 0.0 && frame.metres_per_unit != 1.0)
        lines.push_back(units_line(r));
    if (const Vec3d shift = r.write.global_shift; !(shift == Vec3d{}))
        lines.push_back(fmt::format("global shift: {} {} {}, {}", shift.x, shift.y, shift.z,
                                    r.write.has_translation ? "carried by the node's translation"
                                                            : "taken off the coordinates"));
    if (!frame.crs.name.empty()) lines.push_back(crs_line(r));
    return lines;
}

std::vector<std::pair<std::string, std::string>> frame_facts(const Frame& frame,
                                                             const LoadReport& load) {
    std::vector<std::pair<std::string, std::string>> facts;
    facts.emplace_back("up", frame.up == UpAxis::kAuto ? "not told" : to_word(frame.up));
    if (!frame.unit.empty())
        facts.emplace_back("unit",
                           frame.metres_per_unit == 0.0 || frame.metres_per_unit == 1.0
                               ? frame.unit
                               : fmt::format("{} of {:.10g} m", frame.unit, frame.metres_per_unit));
    if (!frame.crs.name.empty()) facts.emplace_back("CRS", crs_text(frame.crs));
    if (!frame.height_unit.empty()) facts.emplace_back("heights", frame.height_unit);
    if (load.scanners.empty()) return facts;
    constexpr std::size_t kShown = 5;
    facts.emplace_back("scanners", grouped(load.scanners.size()));
    for (std::size_t i = 0; i < std::min(load.scanners.size(), kShown); ++i) {
        const Vec3d p = load.scanners[i];
        facts.emplace_back("scanner at", fmt::format("{:.10g} {:.10g} {:.10g}", p.x, p.y, p.z));
    }
    return facts;
}

}  // namespace pointbake::cli
