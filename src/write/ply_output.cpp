#include "write/ply_output.h"

#include <algorithm>
#include <bit>

#include "core/color.h"
#include "core/message.h"

namespace pointbake {

static_assert(std::endian::native == std::endian::little, "rows are written as they lie in memory");

PlyHeader::PlyHeader() : text_("ply\nformat binary_little_endian 1.0\n") {
    comment("pointbake " POINTBAKE_VERSION);
}

void PlyHeader::comment(std::string_view text) { text_ += fmt::format("comment {}\n", text); }

void PlyHeader::element(std::string_view name, std::size_t count) {
    text_ += fmt::format("element {} {}\n", name, count);
}

void PlyHeader::property(std::string_view type, std::string_view name) {
    text_ += fmt::format("property {} {}\n", type, name);
}

void PlyHeader::properties(std::string_view type, std::initializer_list<std::string_view> names) {
    for (const std::string_view name : names) property(type, name);
}

void PlyRow::add_color(Rgb16 c, bool as_16bit) {
    for (const std::uint16_t v : {c.r, c.g, c.b}) {
        if (as_16bit)
            add(v);
        else
            add(to_8bit(v));
    }
}

bool are_8bit(std::span<const Rgb16> colors) {
    return std::all_of(colors.begin(), colors.end(), [](const Rgb16& c) {
        return c.r % 257 == 0 && c.g % 257 == 0 && c.b % 257 == 0;
    });
}

}  // namespace pointbake
