// LAS and LAZ files made in the test.
#pragma once

#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "io/las_header.h"

namespace pointbake::test {

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof(T));
}

struct TestVlr {
    std::string user_id;
    std::uint16_t id = 0;
    std::string data;
};

struct TestLas {
    int minor = 2;
    int format = 0;  ///< 128 more: compressed
    std::vector<TestVlr> vlrs;
    std::string points;
    std::size_t record_bytes = 0;  ///< 0: as the format has
    std::uint64_t num_points = 0;  ///< 0: as many as `points` holds

    std::string bytes() const {
        const std::size_t header_bytes = minor >= 4 ? 375 : minor == 3 ? 235 : 227;
        std::string out(header_bytes, '\0');
        out.replace(0, 4, "LASF");
        put<std::uint8_t>(out, 24, 1);
        put(out, 25, static_cast<std::uint8_t>(minor));
        put(out, 94, static_cast<std::uint16_t>(header_bytes));
        put(out, 100, static_cast<std::uint32_t>(vlrs.size()));
        put(out, 104, static_cast<std::uint8_t>(format));
        const std::size_t record = record_bytes != 0 ? record_bytes : las_record_bytes(format & 63);
        put(out, 105, static_cast<std::uint16_t>(record));
        const std::uint64_t n = num_points != 0 ? num_points : points.size() / record;
        put(out, 107, static_cast<std::uint32_t>(n));
        if (minor >= 4) put(out, 247, n);
        for (std::size_t k = 0; k < 3; ++k) {
            put(out, 131 + 8 * k, 0.5);
            put(out, 155 + 8 * k, 1000.0 * static_cast<double>(k + 1));
        }
        for (const TestVlr& vlr : vlrs) {
            std::string head(54, '\0');
            head.replace(2, vlr.user_id.size(), vlr.user_id);
            put(head, 18, vlr.id);
            put(head, 20, static_cast<std::uint16_t>(vlr.data.size()));
            out += head + vlr.data;
        }
        put(out, 96, static_cast<std::uint32_t>(out.size()));
        return out + points;
    }
};

/// A record of zeros but for its coordinates.
inline std::string las_record(int format, std::array<std::int32_t, 3> position,
                              std::size_t more = 0) {
    std::string out(las_record_bytes(format) + more, '\0');
    for (std::size_t k = 0; k < 3; ++k) put(out, 4 * k, position[k]);
    return out;
}

inline std::string extra_descriptor(int type, const std::string& name) {
    std::string out(192, '\0');
    put(out, 2, static_cast<std::uint8_t>(type));
    out.replace(4, name.size(), name);
    return out;
}

/// The record that says how the points of format 0 are compressed.
inline TestVlr laz_vlr(int compressor, std::uint32_t chunk_points, std::uint16_t item = 6,
                       std::uint16_t version = 2) {
    std::string data(40, '\0');
    put(data, 0, static_cast<std::uint16_t>(compressor));
    put(data, 12, chunk_points);
    put<std::uint16_t>(data, 32, 1);
    put(data, 34, item);
    put<std::uint16_t>(data, 36, item == 10 ? 30 : 20);
    put(data, 38, version);
    return {"laszip encoded", 22204, data};
}

}  // namespace pointbake::test
