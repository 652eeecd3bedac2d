#include "io/e57_scans.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <pugixml.hpp>

#include "core/message.h"

namespace pointbake {
namespace {

/// Not pugixml's numbers: those depend on the locale.
template <class T>
std::optional<T> number_in(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" \t\r\n+");
    if (begin == std::string_view::npos) return std::nullopt;
    T value{};
    const auto [end, error] =
        std::from_chars(text.data() + begin, text.data() + text.size(), value);
    if (error != std::errc{}) return std::nullopt;
    return value;
}

double attribute(const pugi::xml_node& node, const char* name, double otherwise) {
    return number_in<double>(node.attribute(name).value()).value_or(otherwise);
}

/// An element's number; one without text is 0.
double child_number(const pugi::xml_node& node, const char* name) {
    return number_in<double>(node.child(name).text().get()).value_or(0.0);
}

class ScanReader {
 public:
    ScanReader(const pugi::xml_node& node, const std::string& name, std::size_t number)
        : node_(node), name_(name), number_(number) {}

    E57Scan read() {
        const pugi::xml_node points = node_.child("points");
        scan_.points_at = number_in<std::uint64_t>(points.attribute("fileOffset").value())
                              .value_or(std::numeric_limits<std::uint64_t>::max());
        const std::string_view count = points.attribute("recordCount").value();
        const std::optional<std::uint64_t> num_points = number_in<std::uint64_t>(count);
        if (!num_points)
            fail(ErrorCode::kInvalidInput,
                 "{}: scan {}: recordCount is '{}'; a number of points is wanted", name_, number_,
                 count);
        scan_.num_points = *num_points;
        for (const pugi::xml_node& field : points.child("prototype").children()) add_field(field);
        read_pose();
        read_color_limits();
        return std::move(scan_);
    }

 private:
    void add_field(const pugi::xml_node& node) {
        E57Field field;
        field.name = node.name();
        const std::string_view type = node.attribute("type").value();
        if (type == "Float") {
            const bool is_single =
                std::string_view(node.attribute("precision").value()) == "single";
            field.kind = is_single ? E57Field::Kind::kFloat : E57Field::Kind::kDouble;
            field.num_bits = is_single ? 32 : 64;
            if (node.attribute("minimum") && node.attribute("maximum"))
                field.limits = {attribute(node, "minimum", 0.0), attribute(node, "maximum", 0.0)};
        } else if (type == "Integer" || type == "ScaledInteger") {
            add_range(field, node);
        } else {
            field.kind = E57Field::Kind::kOther;
        }
        scan_.fields.push_back(std::move(field));
    }

    void add_range(E57Field& field, const pugi::xml_node& node) const {
        using Limits = std::numeric_limits<std::int64_t>;
        field.kind = E57Field::Kind::kInteger;
        field.least =
            number_in<std::int64_t>(node.attribute("minimum").value()).value_or(Limits::min());
        const std::int64_t most =
            number_in<std::int64_t>(node.attribute("maximum").value()).value_or(Limits::max());
        if (most < field.least)
            fail(ErrorCode::kInvalidInput, "{}: scan {}: field '{}' goes from {} to {}", name_,
                 number_, field.name, field.least, most);
        field.num_bits = static_cast<unsigned>(std::bit_width(
            static_cast<std::uint64_t>(most) - static_cast<std::uint64_t>(field.least)));
        field.scale = attribute(node, "scale", 1.0);
        field.offset = attribute(node, "offset", 0.0);
        const auto scaled = [&](std::int64_t v) {
            return static_cast<double>(v) * field.scale + field.offset;
        };
        field.limits = {scaled(field.least), scaled(most)};
    }

    void read_pose() {
        const pugi::xml_node pose = node_.child("pose");
        if (!pose) return;
        scan_.has_pose = true;
        const pugi::xml_node t = pose.child("translation"), r = pose.child("rotation");
        scan_.translation = {child_number(t, "x"), child_number(t, "y"), child_number(t, "z")};
        if (!r) return;
        std::array<double, 4> q{child_number(r, "w"), child_number(r, "x"), child_number(r, "y"),
                                child_number(r, "z")};
        const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        if (!(length > 0.0) || !std::isfinite(length))
            fail(ErrorCode::kInvalidInput,
                 "{}: scan {}: the pose's rotation {} {} {} {} is no quaternion", name_, number_,
                 q[0], q[1], q[2], q[3]);
        for (double& v : q) v /= length;
        scan_.rotation = q;
    }

    void read_color_limits() {
        const pugi::xml_node limits = node_.child("colorLimits");
        if (!limits) return;
        const std::array<const char*, 3> names{"colorRed", "colorGreen", "colorBlue"};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::string name = names[k];
            const std::array<double, 2> range{child_number(limits, (name + "Minimum").c_str()),
                                              child_number(limits, (name + "Maximum").c_str())};
            if (range[1] > range[0]) scan_.color_limits[k] = range;
        }
    }

    const pugi::xml_node& node_;
    const std::string& name_;
    std::size_t number_;
    E57Scan scan_;
};

}  // namespace

std::optional<std::size_t> E57Scan::find(std::string_view name) const {
    for (std::size_t i = 0; i < fields.size(); ++i)
        if (fields[i].name == name && fields[i].kind != E57Field::Kind::kOther) return i;
    return std::nullopt;
}

E57Scans read_e57_scans(std::string_view xml, const std::string& name) {
    pugi::xml_document document;
    const pugi::xml_parse_result parsed = document.load_buffer(xml.data(), xml.size());
    if (!parsed)
        fail(ErrorCode::kInvalidInput, "{}: the XML is damaged at its byte {}: {}", name,
             parsed.offset, parsed.description());
    const pugi::xml_node root = document.child("e57Root");
    if (!root) fail(ErrorCode::kInvalidInput, "{}: the XML has no element 'e57Root'", name);
    E57Scans file;
    for (const pugi::xml_node& node : root.child("data3D").children("vectorChild"))
        file.scans.push_back(ScanReader(node, name, file.scans.size() + 1).read());
    file.coordinate_metadata = root.child("coordinateMetadata").text().get();
    return file;
}

}  // namespace pointbake
