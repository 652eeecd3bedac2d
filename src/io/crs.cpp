// PROJ knows what the definitions mean. GeoTIFF's keys are those of OGC 19-008r4.
#include "io/crs.h"

#include <proj.h>

#include <charconv>
#include <map>
#include <memory>

#include "core/message.h"
#include "io/number_type.h"

namespace pointbake {
namespace {

struct FreeContext {
    void operator()(PJ_CONTEXT* context) const { proj_context_destroy(context); }
};
struct FreeObject {
    void operator()(PJ* object) const { proj_destroy(object); }
};
using Object = std::unique_ptr<PJ, FreeObject>;

/// Text of a file on one line.
std::string cleaned(std::string_view text) {
    std::string out;
    for (const char c : text.substr(0, text.find('\0')))
        out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    out.erase(0, out.find_first_not_of(' '));
    return out.erase(out.find_last_not_of(' ') + 1);
}

std::string text_or_empty(const char* text) { return text ? text : ""; }

/// PROJ with its database; it talks to nobody, neither on stderr nor over the network.
class Catalogue {
 public:
    Catalogue() : context_(proj_context_create()) {
        proj_log_func(context_.get(), nullptr, [](void*, int, const char*) {});
        proj_context_set_enable_network(context_.get(), 0);
    }

    Object from_wkt(const std::string& wkt) const {
        return Object(proj_create_from_wkt(context_.get(), wkt.c_str(), nullptr, nullptr, nullptr));
    }
    Object from_code(int code) const {
        return Object(proj_create_from_database(
            context_.get(), "EPSG", fmt::format("{}", code).c_str(), PJ_CATEGORY_CRS, 0, nullptr));
    }

    /// False if the code is that of no length.
    bool add_unit(Frame& frame, int code) const {
        const char *name = nullptr, *category = nullptr;
        double factor = 0.0;
        if (!proj_uom_get_info_from_database(context_.get(), "EPSG",
                                             fmt::format("{}", code).c_str(), &name, &factor,
                                             &category) ||
            std::string_view(category) != "linear" || !(factor > 0.0))
            return false;
        frame.metres_per_unit = factor;
        frame.unit = text_or_empty(name);
        return true;
    }

    void describe(Frame& frame, const PJ* whole) const {
        Object bound, horizontal, vertical;
        if (proj_get_type(whole) == PJ_TYPE_BOUND_CRS) {  // with a way to another one
            bound.reset(proj_get_source_crs(context_.get(), whole));
            whole = bound.get();
        }
        Crs& crs = frame.crs;
        crs = {};
        crs.name = cleaned(text_or_empty(proj_get_name(whole)));
        crs.epsg = epsg_of(whole);
        const PJ* flat = whole;
        if (proj_get_type(whole) == PJ_TYPE_COMPOUND_CRS) {
            horizontal.reset(proj_crs_get_sub_crs(context_.get(), whole, 0));
            vertical.reset(proj_crs_get_sub_crs(context_.get(), whole, 1));
            flat = horizontal.get();
            if (crs.epsg == 0) crs.epsg = epsg_of(flat);
        }
        if (vertical) add_vertical(frame, vertical.get());
        add_axes(frame, flat);
        crs.wkt = esri_wkt(flat);
    }

    void add_vertical(Frame& frame, const PJ* vertical) const {
        Frame heights;
        add_axes(heights, vertical);
        frame.crs.vertical = cleaned(text_or_empty(proj_get_name(vertical)));
        frame.height_unit = heights.unit;
    }

 private:
    static int epsg_of(const PJ* crs) {
        const std::string authority = text_or_empty(proj_get_id_auth_name(crs, 0));
        const std::string code = text_or_empty(proj_get_id_code(crs, 0));
        int number = 0;
        std::from_chars(code.data(), code.data() + code.size(), number);
        return authority == "EPSG" ? number : 0;
    }

    void add_axes(Frame& frame, const PJ* crs) const {
        const Object system(proj_crs_get_coordinate_system(context_.get(), crs));
        const char* unit = nullptr;
        double factor = 0.0;
        if (!system || !proj_cs_get_axis_info(context_.get(), system.get(), 0, nullptr, nullptr,
                                              nullptr, &factor, &unit, nullptr, nullptr))
            return;
        const PJ_COORDINATE_SYSTEM_TYPE type = proj_cs_get_type(context_.get(), system.get());
        frame.crs.is_geographic = type == PJ_CS_TYPE_ELLIPSOIDAL;
        frame.unit = cleaned(text_or_empty(unit));
        frame.metres_per_unit = frame.crs.is_geographic || !(factor > 0.0) ? 0.0 : factor;
    }

    /// What programs expect in a .prj; WKT 2 where the older one cannot say it.
    std::string esri_wkt(const PJ* crs) const {
        constexpr const char* kOneLine[] = {"MULTILINE=NO", nullptr};
        for (const PJ_WKT_TYPE type : {PJ_WKT1_ESRI, PJ_WKT2_2019})
            if (const char* const text = proj_as_wkt(context_.get(), crs, type, kOneLine))
                return text;
        return {};
    }

    std::unique_ptr<PJ_CONTEXT, FreeContext> context_;
};

int epsg_code(std::string_view definition) {
    constexpr std::string_view kPrefix = "EPSG:";
    int code = 0;
    if (definition.starts_with(kPrefix))
        std::from_chars(definition.data() + kPrefix.size(), definition.data() + definition.size(),
                        code);
    return code;
}

/// The keys that are read of a GeoTIFF's directory.
class GeoKeys {
 public:
    GeoKeys(std::span<const std::byte> keys, std::string_view texts) : texts_(texts) {
        constexpr std::size_t kEntryBytes = 8;
        for (std::size_t at = kEntryBytes; at + kEntryBytes <= keys.size(); at += kEntryBytes) {
            const auto word = [&](std::size_t k) {
                return load_value<std::uint16_t>(keys.data() + at + 2 * k);
            };
            entries_.emplace(word(0), Entry{word(1), word(2), word(3)});
        }
    }

    /// 0 if it is not there.
    int code(std::uint16_t key) const {
        const auto found = entries_.find(key);
        return found == entries_.end() || found->second.place != 0 ? 0 : found->second.value;
    }
    std::string text(std::uint16_t key) const {
        constexpr std::uint16_t kTextRecord = 34737;
        const auto found = entries_.find(key);
        if (found == entries_.end() || found->second.place != kTextRecord ||
            found->second.value >= texts_.size())
            return {};
        const std::string_view text = texts_.substr(found->second.value, found->second.count);
        return cleaned(text.substr(0, text.find('|')));
    }

 private:
    struct Entry {
        std::uint16_t place, count, value;
    };
    std::map<std::uint16_t, Entry> entries_;
    std::string_view texts_;
};

constexpr int kUserDefined = 32767;

bool is_code(int value) { return value > 0 && value < kUserDefined; }

}  // namespace

std::string add_crs(Frame& frame, std::string_view definition) {
    const std::string text = cleaned(definition);
    if (text.empty()) return {};
    const Catalogue catalogue;
    const int code = epsg_code(text);
    const Object found = code != 0 ? catalogue.from_code(code) : catalogue.from_wkt(text);
    constexpr std::size_t kShown = 60;
    if (!found || !proj_is_crs(found.get()))
        return fmt::format("coordinate system not understood: {}{}", text.substr(0, kShown),
                           text.size() > kShown ? "..." : "");
    catalogue.describe(frame, found.get());
    return {};
}

std::string add_crs(Frame& frame, std::span<const std::byte> keys, std::string_view texts) {
    constexpr std::uint16_t kModel = 1024, kCitation = 1026, kGeographic = 2048;
    constexpr std::uint16_t kProjected = 3072, kProjectedCitation = 3073, kUnit = 3076;
    constexpr std::uint16_t kVertical = 4096;
    constexpr int kProjectedModel = 1, kGeographicModel = 2;
    const GeoKeys entries(keys, texts);
    const Catalogue catalogue;
    const bool is_projected =
        entries.code(kModel) == kProjectedModel || entries.code(kProjected) != 0;
    const int code = entries.code(is_projected ? kProjected : kGeographic);
    std::string note;
    if (is_code(code)) {
        if (const Object found = catalogue.from_code(code))
            catalogue.describe(frame, found.get());
        else
            note = fmt::format("coordinate system EPSG:{} is not known", code);
    }
    if (frame.crs.name.empty()) {  // of the file's own making
        frame.crs.name = entries.text(is_projected ? kProjectedCitation : kCitation);
        if (frame.crs.name.empty()) frame.crs.name = entries.text(kCitation);
        frame.crs.is_geographic = !is_projected && entries.code(kModel) == kGeographicModel;
    }
    if (const int vertical = entries.code(kVertical); is_code(vertical))
        if (const Object found = catalogue.from_code(vertical))
            catalogue.add_vertical(frame, found.get());
    const int unit = entries.code(kUnit);
    if (is_projected && is_code(unit) && !catalogue.add_unit(frame, unit))
        note = fmt::format("{} is the code of no unit of length", unit);
    return note;
}

std::string frame_warning(const Frame& frame) {
    if (frame.crs.is_geographic)
        return fmt::format(
            "x and y are angles of {}, no lengths: what is made of them is distorted; transform "
            "the points into a projected system first, such as UTM",
            frame.crs.name);
    if (!frame.height_unit.empty() && frame.height_unit != frame.unit)
        return fmt::format(
            "heights are in {}, x and y in {}: the model is as distorted as the points; bring them "
            "to one unit first",
            frame.height_unit, frame.unit);
    return {};
}

}  // namespace pointbake
