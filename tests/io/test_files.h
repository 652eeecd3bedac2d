// Files for the readers' tests, made in the test: PLY of every dialect, PNG and JPEG images.
#pragma once

#include <gtest/gtest.h>
#include <spng.h>
#include <turbojpeg.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "pointbake/error.h"
#include "pointbake/load.h"

namespace pointbake::test {

/// A folder that goes away with the test.
class TempFolder {
 public:
    TempFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "pointbake_XXXXXX").string();
        path_ = ::mkdtemp(name.data());
    }
    ~TempFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TempFolder(const TempFolder&) = delete;
    TempFolder& operator=(const TempFolder&) = delete;

    std::filesystem::path write(const std::string& name, const std::string& bytes) const {
        std::ofstream(path_ / name, std::ios::binary) << bytes;
        return path_ / name;
    }
    const std::filesystem::path& path() const { return path_; }

 private:
    std::filesystem::path path_;
};

inline LoadResult load_bytes(const std::string& bytes, const Context& context = {}) {
    const TempFolder folder;
    return load_cloud(folder.write("cloud.ply", bytes), {}, context);
}

/// A file of that name; options as given.
inline LoadResult load_as(const std::string& name, const std::string& bytes,
                          const LoadOptions& options = {}, const Context& context = {}) {
    const TempFolder folder;
    return load_cloud(folder.write(name, bytes), options, context);
}

inline bool has_note(const LoadResult& result, const std::string& part) {
    return std::any_of(result.report.notes.begin(), result.report.notes.end(),
                       [&](const std::string& note) { return note.find(part) != note.npos; });
}

/// The error that `call` throws; fails the test if it throws none.
template <class Call>
Error error_of(Call&& call) {
    try {
        call();
    } catch (const Error& e) {
        return e;
    }
    ADD_FAILURE() << "no error";
    return {ErrorCode::kOutput, ""};
}

/// Fails the test unless reading these bytes throws such an error.
inline void expect_load_error(const std::string& name, const std::string& bytes, ErrorCode code,
                              const std::string& part, const LoadOptions& options = {}) {
    const Error error = error_of([&] { load_as(name, bytes, options); });
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos)
        << error.what() << "\nwants: " << part;
}

inline const char* const kFormats[] = {"ascii", "binary_little_endian", "binary_big_endian"};

struct TestProperty {
    std::string type;
    std::string name;
    std::vector<std::vector<double>> rows;  ///< one value each, or a list's
    std::string count_type = {};            ///< set for lists
};

struct TestElement {
    std::string name;
    std::vector<TestProperty> properties;
};

inline TestProperty column(std::string type, std::string name, const std::vector<double>& values) {
    TestProperty p{std::move(type), std::move(name), {}, {}};
    for (double v : values) p.rows.push_back({v});
    return p;
}

inline void append_value(std::string& out, const std::string& type, const std::string& format,
                         double value) {
    const auto add = [&](auto typed) {
        if (format == "ascii") {
            char text[40];
            std::snprintf(text, sizeof text, "%.17g ", static_cast<double>(typed));
            out += text;
            return;
        }
        char raw[sizeof typed];
        std::memcpy(raw, &typed, sizeof typed);
        if (format == "binary_big_endian") std::reverse(raw, raw + sizeof typed);
        out.append(raw, sizeof typed);
    };
    if (type == "char" || type == "int8") return add(static_cast<std::int8_t>(value));
    if (type == "uchar" || type == "uint8") return add(static_cast<std::uint8_t>(value));
    if (type == "short" || type == "int16") return add(static_cast<std::int16_t>(value));
    if (type == "ushort" || type == "uint16") return add(static_cast<std::uint16_t>(value));
    if (type == "int" || type == "int32") return add(static_cast<std::int32_t>(value));
    if (type == "uint" || type == "uint32") return add(static_cast<std::uint32_t>(value));
    if (type == "float" || type == "float32") return add(static_cast<float>(value));
    add(value);
}

inline std::string make_ply(const std::string& format, const std::vector<TestElement>& elements) {
    std::string out = "ply\nformat " + format + " 1.0\n";
    for (const TestElement& e : elements) {
        out += "element " + e.name + " " + std::to_string(e.properties[0].rows.size()) + "\n";
        for (const TestProperty& p : e.properties)
            out += "property " + (p.count_type.empty() ? "" : "list " + p.count_type + " ") +
                   p.type + " " + p.name + "\n";
    }
    out += "end_header\n";
    for (const TestElement& e : elements)
        for (std::size_t row = 0; row < e.properties[0].rows.size(); ++row) {
            for (const TestProperty& p : e.properties) {
                if (!p.count_type.empty())
                    append_value(out, p.count_type, format,
                                 static_cast<double>(p.rows[row].size()));
                for (double v : p.rows[row]) append_value(out, p.type, format, v);
            }
            if (format == "ascii") out += "\n";
        }
    return out;
}

/// Three points off one line: (0,0,0), (1,0,0), (0,2,0) as floats, and more columns.
inline TestElement three_points(std::vector<TestProperty> more = {}) {
    TestElement e{"vertex",
                  {column("float", "x", {0, 1, 0}), column("float", "y", {0, 0, 2}),
                   column("float", "z", {0, 0, 0})}};
    for (TestProperty& p : more) e.properties.push_back(std::move(p));
    return e;
}

/// The point that came from an input row.
inline std::size_t point_of_row(const PointCloud& cloud, std::uint64_t row) {
    return static_cast<std::size_t>(std::find(cloud.rows.begin(), cloud.rows.end(), row) -
                                    cloud.rows.begin());
}

inline const Channel* find_channel(const PointCloud& cloud, const std::string& name) {
    for (const Channel& c : cloud.channels)
        if (c.name == name) return &c;
    return nullptr;
}

/// 8-bit RGB pixels as a PNG file's bytes.
inline std::string make_png(int width, int height, const std::vector<std::uint8_t>& pixels) {
    spng_ctx* context = spng_ctx_new(SPNG_CTX_ENCODER);
    spng_set_option(context, SPNG_ENCODE_TO_BUFFER, 1);
    spng_ihdr header{};
    header.width = static_cast<std::uint32_t>(width);
    header.height = static_cast<std::uint32_t>(height);
    header.bit_depth = 8;
    header.color_type = SPNG_COLOR_TYPE_TRUECOLOR;
    spng_set_ihdr(context, &header);
    spng_encode_image(context, pixels.data(), pixels.size(), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
    std::size_t size = 0;
    int error = 0;
    void* bytes = spng_get_png_buffer(context, &size, &error);
    std::string out(static_cast<const char*>(bytes), size);
    std::free(bytes);
    spng_ctx_free(context);
    return out;
}

inline std::string make_jpeg(int width, int height, std::vector<std::uint8_t> pixels) {
    tjhandle encoder = tjInitCompress();
    unsigned char* bytes = nullptr;
    unsigned long size = 0;
    tjCompress2(encoder, pixels.data(), width, 0, height, TJPF_RGB, &bytes, &size, TJSAMP_444, 95,
                0);
    std::string out(reinterpret_cast<const char*>(bytes), size);
    tjFree(bytes);
    tjDestroy(encoder);
    return out;
}

}  // namespace pointbake::test
