// A record "laszip encoded" says what the parts of a point are and how many points a chunk has. The
// compressed points begin with the place of a table of the chunks' sizes, which stands behind them.
#include "io/read_laz.h"

#include <algorithm>
#include <optional>

#include "core/message.h"
#include "core/parallel.h"
#include "io/arithmetic_decoder.h"
#include "io/laz_chunk.h"

namespace pointbake {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::uint32_t kVariableChunks = ~0U;
constexpr std::size_t kPlaceBytes = 8;  // of the table's place

struct Chunk {
    std::size_t at = 0, num_bytes = 0;
    std::size_t first_row = 0, num_rows = 0;
};

/// How the points are compressed.
struct Encoding {
    enum class Kind : std::uint16_t { kNone, kWhole, kChunked, kLayered };
    Kind kind = Kind::kNone;
    std::uint32_t chunk_points = 0;  ///< kVariableChunks: the table says how many
    std::vector<LazItem> items;
};

/// Bytes that a part must have; 0: any number.
std::size_t bytes_of(LazItemKind kind) {
    switch (kind) {
        case LazItemKind::kPoint10:
            return 20;
        case LazItemKind::kGpsTime:
        case LazItemKind::kRgbNir14:
            return 8;
        case LazItemKind::kRgb:
        case LazItemKind::kRgb14:
            return 6;
        case LazItemKind::kWavePacket13:
        case LazItemKind::kWavePacket14:
            return 29;
        case LazItemKind::kPoint14:
            return 30;
        default:
            return 0;
    }
}

class EncodingReader {
 public:
    EncodingReader(const LasHeader& header, const std::string& name)
        : header_(header), name_(name), vlr_(header.laz_vlr) {}

    Encoding read() {
        constexpr std::size_t kFixedBytes = 34;
        if (vlr_.empty())
            fail(ErrorCode::kInvalidInput,
                 "{}: the points are compressed, but there is no record 'laszip encoded' that says "
                 "how",
                 name_);
        if (vlr_.size() < kFixedBytes) fail_short();
        Encoding encoding;
        const auto kind = value(0), coder = value(2);
        if (kind < 1 || kind > 3 || coder != 0)
            fail(ErrorCode::kUnsupported,
                 "{}: LAZ compressor {} with coder {}; compressors 1 to 3 with coder 0 are read",
                 name_, kind, coder);
        encoding.kind = static_cast<Encoding::Kind>(kind);
        encoding.chunk_points = load_value<std::uint32_t>(vlr_.data() + 12);
        if (encoding.chunk_points == 0 && encoding.kind != Encoding::Kind::kWhole)
            fail(ErrorCode::kInvalidInput, "{}: chunks of 0 points", name_);
        const std::size_t num_items = value(32);
        constexpr std::size_t kItemBytes = 6;
        if ((vlr_.size() - kFixedBytes) / kItemBytes < num_items) fail_short();
        for (std::size_t i = 0; i < num_items; ++i)
            encoding.items.push_back(read_item(kFixedBytes + i * kItemBytes, encoding.kind));
        check_items(encoding);
        return encoding;
    }

 private:
    std::uint16_t value(std::size_t at) const {
        return load_value<std::uint16_t>(vlr_.data() + at);
    }

    [[noreturn]] void fail_short() const {
        fail(ErrorCode::kInvalidInput,
             "{}: the record 'laszip encoded' is cut off: it has {} bytes", name_, vlr_.size());
    }

    LazItem read_item(std::size_t at, Encoding::Kind kind) const {
        const std::uint16_t type = value(at), num_bytes = value(at + 2), version = value(at + 4);
        const LazItem item{static_cast<LazItemKind>(type), num_bytes, version};
        const bool is_layered = kind == Encoding::Kind::kLayered;
        if (item.kind == LazItemKind::kWavePacket13)
            fail(ErrorCode::kUnsupported,
                 "{}: compressed wave packets (point format {}) are not read; uncompressed they "
                 "are skipped: laszip -i FILE -o FILE.las",
                 name_, header_.point_format);
        const bool is_old = type == 0 || (type >= 6 && type <= 8);
        const bool is_new = type >= 10 && type <= 14;
        if (is_layered ? !is_new || version < 3 || version > 4 : !is_old || version != 2)
            fail(ErrorCode::kUnsupported,
                 "{}: LAZ item {} of version {}; items 0 and 6 to 8 of version 2, and in layers 10 "
                 "to 14 of versions 3 and 4, are read",
                 name_, type, version);
        if (bytes_of(item.kind) != 0 && item.num_bytes != bytes_of(item.kind))
            fail(ErrorCode::kInvalidInput, "{}: LAZ item {} of {} bytes; it has {}", name_, type,
                 num_bytes, bytes_of(item.kind));
        return item;
    }

    void check_items(const Encoding& encoding) const {
        const bool is_layered = encoding.kind == Encoding::Kind::kLayered;
        const LazItemKind first = is_layered ? LazItemKind::kPoint14 : LazItemKind::kPoint10;
        if (encoding.items.empty() || encoding.items[0].kind != first ||
            is_layered != is_new_las_format(header_.point_format) ||
            record_bytes(encoding.items) != header_.record_bytes)
            fail(ErrorCode::kInvalidInput,
                 "{}: the parts of a compressed point have {} bytes together, the records of point "
                 "format {} have {}",
                 name_, record_bytes(encoding.items), header_.point_format, header_.record_bytes);
    }

    const LasHeader& header_;
    const std::string& name_;
    Bytes vlr_;
};

class LazReader {
 public:
    LazReader(Bytes bytes, const LasHeader& header, const std::string& name, const LazSink& sink,
              const Context& context)
        : bytes_(bytes),
          header_(header),
          name_(name),
          sink_(sink),
          context_(context),
          encoding_(EncodingReader(header, name).read()) {
        check_size();
    }

    std::string read() {
        sink_.allocate();
        if (const std::optional<std::vector<Chunk>> chunks = find_chunks()) {
            parallel_for(context_, chunks->size(), 1,
                         [&](std::size_t begin, std::size_t) { read_chunk((*chunks)[begin]); });
            return {};
        }
        read_in_sequence();
        return encoding_.kind == Encoding::Kind::kWhole
                   ? ""
                   : "the table of chunks is missing or wrong: they were read one after the other";
    }

 private:
    /// Points that hardly change take next to no bytes, so that the header's count cannot be told
    /// from the size; but no real file is packed like that.
    void check_size() const {
        constexpr std::uint64_t kSureBytes = 8ULL << 20, kMostTimes = 200;
        const std::uint64_t most = std::max(kSureBytes, bytes_.size() * kMostTimes);
        if (header_.num_points > most / header_.record_bytes)
            fail(ErrorCode::kLimit,
                 "{}: the header promises {} points of {} bytes, but the file has {} bytes: more "
                 "than 8 MiB and {} times its size is not believed",
                 name_, header_.num_points, header_.record_bytes, bytes_.size(), kMostTimes);
    }

    std::size_t num_rows() const { return static_cast<std::size_t>(header_.num_points); }

    std::size_t begin_of_chunks() const {
        return header_.points_at + (encoding_.kind == Encoding::Kind::kWhole ? 0 : kPlaceBytes);
    }

    /// Where the table says that it is; a writer that cannot go back puts the place at the end.
    std::optional<std::size_t> find_table() const {
        if (bytes_.size() - header_.points_at < 2 * kPlaceBytes) return std::nullopt;
        for (const std::size_t at : {header_.points_at, bytes_.size() - kPlaceBytes}) {
            const auto place = load_value<std::uint64_t>(bytes_.data() + at);
            if (place >= begin_of_chunks() && place < bytes_.size() &&
                bytes_.size() - place >= kPlaceBytes)
                return static_cast<std::size_t>(place);
        }
        return std::nullopt;
    }

    /// From the table, if all that it says is possible.
    std::optional<std::vector<Chunk>> find_chunks() const {
        if (encoding_.kind == Encoding::Kind::kWhole) return std::nullopt;
        const std::optional<std::size_t> table = find_table();
        if (!table) return std::nullopt;
        const auto version = load_value<std::uint32_t>(bytes_.data() + *table);
        const auto num_chunks = load_value<std::uint32_t>(bytes_.data() + *table + 4);
        // Each chunk has a whole point in front.
        const std::size_t room = *table - begin_of_chunks();
        if (version != 0 || num_chunks > room / header_.record_bytes) return std::nullopt;
        const bool is_variable = encoding_.chunk_points == kVariableChunks;

        ArithmeticDecoder decoder(bytes_.subspan(*table + kPlaceBytes));
        IntegerDecoder numbers(32, 2);
        std::vector<Chunk> chunks(num_chunks);
        std::uint32_t points = 0, size = 0;
        std::size_t at = begin_of_chunks(), row = 0;
        const auto next = [&](std::uint32_t last, std::size_t context) {
            return static_cast<std::uint32_t>(
                numbers.read(decoder, static_cast<std::int32_t>(last), context));
        };
        for (Chunk& chunk : chunks) {
            if (is_variable) points = next(points, 0);
            size = next(size, 1);
            const std::size_t left = num_rows() - row;
            if (size > *table - at || (is_variable && points > left)) return std::nullopt;
            const std::size_t num =
                is_variable ? points : std::min<std::size_t>(encoding_.chunk_points, left);
            if (num == 0 && !is_variable) return std::nullopt;
            chunk = {at, size, row, num};
            at += size;
            row += num;
        }
        if (decoder.is_overrun() || row != num_rows()) return std::nullopt;
        return chunks;
    }

    std::size_t read_chunk(const Chunk& chunk) const {
        std::vector<std::byte> records(chunk.num_rows * header_.record_bytes);
        const Bytes packed = bytes_.subspan(chunk.at, chunk.num_bytes);
        const std::optional<std::size_t> num_read =
            encoding_.kind == Encoding::Kind::kLayered
                ? unpack_layered(packed, encoding_.items, records)
                : unpack_pointwise(packed, encoding_.items, records);
        if (!num_read)
            fail(ErrorCode::kInvalidInput,
                 "{}: byte {}: {} points are promised, but the {} bytes that hold them do not "
                 "unpack to as many: the file is damaged or cut off",
                 name_, chunk.at, chunk.num_rows, chunk.num_bytes);
        sink_.store(chunk.first_row, chunk.num_rows, records.data());
        return *num_read;
    }

    /// Each chunk ends where its last point was read.
    void read_in_sequence() const {
        std::size_t at = std::min(begin_of_chunks(), bytes_.size());
        for (std::size_t row = 0; row < num_rows();) {
            check_cancelled(context_);
            const std::size_t left = num_rows() - row;
            Chunk chunk{at, bytes_.size() - at, row, left};
            if (encoding_.kind == Encoding::Kind::kChunked)
                chunk.num_rows = std::min<std::size_t>(left, encoding_.chunk_points);
            if (encoding_.kind == Encoding::Kind::kLayered)
                chunk.num_rows = std::min<std::size_t>(left, layered_points(chunk));
            at += read_chunk(chunk);
            row += chunk.num_rows;
        }
    }

    std::size_t layered_points(const Chunk& chunk) const {
        const std::optional<LayeredSize> size =
            layered_size(bytes_.subspan(chunk.at), encoding_.items);
        if (!size || size->num_points == 0)
            fail(ErrorCode::kInvalidInput,
                 "{}: byte {}: no chunk of points, though {} are still promised: the file is "
                 "damaged or cut off",
                 name_, chunk.at, chunk.num_rows);
        return size->num_points;
    }

    Bytes bytes_;
    const LasHeader& header_;
    const std::string& name_;
    const LazSink& sink_;
    const Context& context_;
    Encoding encoding_;
};

}  // namespace

std::string unpack_laz(Bytes bytes, const LasHeader& header, const std::string& name,
                       const LazSink& sink, const Context& context) {
    return LazReader(bytes, header, name, sink, context).read();
}

}  // namespace pointbake
