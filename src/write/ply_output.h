// What both PLY writers share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/atomic_file.h"
#include "pointbake/types.h"

namespace pointbake {

/// Header lines of a binary little-endian PLY.
class PlyHeader {
 public:
    PlyHeader();
    void comment(std::string_view text);
    void element(std::string_view name, std::size_t count);
    void property(std::string_view type, std::string_view name);
    void properties(std::string_view type, std::initializer_list<std::string_view> names);
    /// The whole header.
    std::string text() const { return text_ + "end_header\n"; }

 private:
    std::string text_;
};

/// Collects the bytes of a row.
class PlyRow {
 public:
    template <class T>
    void add(T value) {
        const auto bytes = std::as_bytes(std::span<const T>(&value, 1));
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    }
    template <class T>
    void add(Vec3<T> v) {
        add(v.x);
        add(v.y);
        add(v.z);
    }
    /// A coordinate triple, as doubles or floats.
    void add_position(Vec3d p, bool as_double) {
        if (as_double)
            add(p);
        else
            add(vec_cast<float>(p));
    }
    /// A colour, with 16 or 8 bits.
    void add_color(Rgb16 c, bool as_16bit);
    void write_to(AtomicFile& file) {
        file.write(bytes_);
        bytes_.clear();
    }

 private:
    std::vector<std::byte> bytes_;
};

/// Whether 8 bits hold every colour.
bool are_8bit(std::span<const Rgb16> colors);

}  // namespace pointbake
