#include "io/e57_streams.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "core/message.h"
#include "io/number_type.h"

namespace pointbake {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kSectionBytes = 32;  // header of a scan's binary section
constexpr std::size_t kPacketBytes = 6;    // of a packet of data
constexpr std::uint8_t kVectorSection = 1;
enum PacketType : std::uint8_t { kIndexPacket = 0, kDataPacket = 1, kEmptyPacket = 2 };

}  // namespace

E57Streams::E57Streams(const E57File& file, const E57Scan& scan, const std::string& name)
    : scan_(scan), name_(name), streams_(scan.fields.size()) {
    const std::size_t at = file.place(scan.points_at);
    const std::size_t room = file.content.size() - at;
    const auto fail_section = [&](std::string_view problem) {
        fail(ErrorCode::kInvalidInput, "{}: byte {}: {}; a section of points is wanted here", name_,
             scan.points_at, problem);
    };
    if (room < kSectionBytes) fail_section("the file ends");
    const std::byte* const header = file.content.data() + at;
    if (load_value<std::uint8_t>(header) != kVectorSection) fail_section("another kind of section");
    const auto length = load_value<std::uint64_t>(header + 8);
    if (length < kSectionBytes || length > room) fail_section("its length is impossible");
    const std::size_t end = at + static_cast<std::size_t>(length);
    const std::size_t data = file.place(load_value<std::uint64_t>(header + 16));
    if (data < at || data > end) fail_section("its data lie elsewhere");
    read_packets(file, data, end);
    check_lengths();
}

void E57Streams::read_packets(const E57File& file, std::size_t at, std::size_t end) {
    while (end - at >= 4) {
        const std::byte* const packet = file.content.data() + at;
        const auto type = load_value<std::uint8_t>(packet);
        const std::size_t length = std::size_t{load_value<std::uint16_t>(packet + 2)} + 1;
        if (type > kEmptyPacket || length < 4 || length > end - at)
            fail(ErrorCode::kInvalidInput,
                 "{}: byte {} of the pages: a packet of kind {} with {} bytes, where {} are left",
                 name_, at, type, length, end - at);
        if (type == kDataPacket) read_data_packet({packet, length}, at);
        at += length;
    }
}

void E57Streams::read_data_packet(Bytes packet, std::size_t at) {
    const auto fail_packet = [&] {
        fail(ErrorCode::kInvalidInput,
             "{}: byte {} of the pages: a packet of {} bytes does not hold the {} streams of the "
             "points",
             name_, at, packet.size(), streams_.size());
    };
    const std::size_t num_streams = streams_.size();
    if (packet.size() < kPacketBytes + 2 * num_streams ||
        load_value<std::uint16_t>(packet.data() + 4) != num_streams)
        fail_packet();
    std::size_t from = kPacketBytes + 2 * num_streams;
    for (std::size_t k = 0; k < num_streams; ++k) {
        const std::size_t length = load_value<std::uint16_t>(packet.data() + kPacketBytes + 2 * k);
        if (length > packet.size() - from) fail_packet();
        const Bytes part = packet.subspan(from, length);
        streams_[k].insert(streams_[k].end(), part.begin(), part.end());
        from += length;
    }
}

void E57Streams::check_lengths() const {
    // Points of no bits at all are all the same; no file needs many.
    constexpr std::uint64_t kMostWithoutBits = 1 << 18;
    std::uint64_t most = kMostWithoutBits;
    bool has_bits = false;
    for (std::size_t k = 0; k < streams_.size(); ++k) {
        const E57Field& field = scan_.fields[k];
        if (field.kind == E57Field::Kind::kOther || field.num_bits == 0) continue;
        const std::uint64_t there = std::uint64_t{streams_[k].size()} * 8 / field.num_bits;
        most = has_bits ? std::min(most, there) : there;
        has_bits = true;
    }
    if (scan_.num_points > most)
        fail(ErrorCode::kInvalidInput,
             "{}: byte {}: a scan of {} points is promised, but bytes are there for only {}: the "
             "file is cut off, or it is wrong",
             name_, scan_.points_at, scan_.num_points, most);
}

std::uint64_t E57Streams::bits_at(std::size_t field, std::size_t point) const {
    const std::vector<std::byte>& stream = streams_[field];
    const unsigned num_bits = scan_.fields[field].num_bits;
    const std::size_t bit = point * num_bits, first = bit / 8;
    const unsigned shift = bit % 8;
    std::uint64_t value = 0;
    std::memcpy(&value, stream.data() + first, std::min<std::size_t>(8, stream.size() - first));
    value >>= shift;
    if (shift + num_bits > 64)
        value |= std::to_integer<std::uint64_t>(stream[first + 8]) << (64 - shift);
    return num_bits < 64 ? value & ((std::uint64_t{1} << num_bits) - 1) : value;
}

void E57Streams::load(std::size_t field, std::size_t first_point, std::span<double> to) const {
    const E57Field& f = scan_.fields[field];
    const std::byte* const stream = streams_[field].data();
    if (f.kind == E57Field::Kind::kFloat)
        return load_column(NumberType::kFloat32, stream + 4 * first_point, 4, false, to);
    if (f.kind == E57Field::Kind::kDouble)
        return load_column(NumberType::kFloat64, stream + 8 * first_point, 8, false, to);
    for (std::size_t i = 0; i < to.size(); ++i) {
        const std::uint64_t steps = f.num_bits == 0 ? 0 : bits_at(field, first_point + i);
        const auto value = static_cast<std::int64_t>(static_cast<std::uint64_t>(f.least) + steps);
        to[i] = static_cast<double>(value) * f.scale + f.offset;
    }
}

}  // namespace pointbake
