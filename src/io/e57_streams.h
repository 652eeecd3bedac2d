// The binary part of a scan: one stream of bits per field, cut into packets.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "io/e57_pages.h"
#include "io/e57_scans.h"

namespace pointbake {

class E57Streams {
 public:
    /// Finds all packets; after it, the bits of all points are known to be there. Throws
    /// Error{kInvalidInput} naming `name`.
    E57Streams(const E57File& file, const E57Scan& scan, const std::string& name);

    /// The values of consecutive points, scaled.
    void load(std::size_t field, std::size_t first_point, std::span<double> to) const;

 private:
    void read_packets(const E57File& file, std::size_t at, std::size_t end);
    void read_data_packet(std::span<const std::byte> packet, std::size_t at);
    void check_lengths() const;
    std::uint64_t bits_at(std::size_t field, std::size_t point) const;

    const E57Scan& scan_;
    const std::string& name_;
    std::vector<std::vector<std::byte>> streams_;
};

}  // namespace pointbake
