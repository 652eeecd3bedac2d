// Binary points lie row by row; compressed ones field by field, behind two sizes of 32 bits each.
#include "io/read_pcd.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/message.h"
#include "core/parallel.h"
#include "io/finish_cloud.h"
#include "io/lzf.h"
#include "io/pcd_header.h"
#include "io/text_points.h"

namespace pointbake {
namespace {

constexpr std::size_t kBlockRows = 4096;
// Histograms and descriptors with more values per point than this are left out.
constexpr std::size_t kMostComponents = 64;
constexpr int kNotPacked = -1;

/// Where the values of a column come from.
struct Source {
    std::size_t field = 0;
    std::size_t component = 0;
    int shift = kNotPacked;  ///< of the byte in a packed colour
};

struct Columns {
    std::vector<TableColumn> columns;
    std::vector<Source> sources;
    std::vector<std::string> notes;

    void add(TableColumn column, Source source) {
        columns.push_back(std::move(column));
        sources.push_back(source);
    }
};

bool is_packed_color(const PcdField& field) {
    return (field.name == "rgb" || field.name == "rgba") && field.count == 1 &&
           size_of(field.type) == 4;
}

Columns columns_of(const PcdHeader& header) {
    Columns out;
    for (std::size_t i = 0; i < header.fields.size(); ++i) {
        const PcdField& field = header.fields[i];
        if (field.name == "_" || field.count == 0) continue;  // padding
        if (is_packed_color(field)) {
            out.add({"red", NumberType::kUint8}, {i, 0, 16});
            out.add({"green", NumberType::kUint8}, {i, 0, 8});
            out.add({"blue", NumberType::kUint8}, {i, 0, 0});
            if (field.name == "rgba") out.add({"alpha", NumberType::kUint8}, {i, 0, 24});
        } else if (field.count == 1) {
            out.add({field.name, field.type}, {i, 0, kNotPacked});
        } else if (field.count <= kMostComponents) {
            for (std::size_t k = 0; k < field.count; ++k)
                out.add({fmt::format("{}_{}", field.name, k), field.type}, {i, k, kNotPacked});
        } else {
            out.notes.push_back(
                fmt::format("field '{}' ignored: {} values per point", field.name, field.count));
        }
    }
    return out;
}

/// The bits of a packed colour that text shows as a number: a float's bits are meant, where the
/// field is one.
std::uint32_t packed_of(double value, NumberType type) {
    if (is_float(type)) return std::bit_cast<std::uint32_t>(static_cast<float>(value));
    if (!(value >= -2147483648.0 && value <= 4294967295.0)) return 0;
    return static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
}

class PcdReader {
 public:
    PcdReader(std::span<const std::byte> bytes, const std::string& path, const Context& context)
        : bytes_(bytes),
          name_(path),
          context_(context),
          text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
          header_(read_pcd_header(text_, path)),
          columns_(columns_of(header_)),
          table_(columns_.columns, path, "the header has no field") {
        if (header_.num_points == 0) fail(ErrorCode::kEmpty, "{}: the file holds 0 points", name_);
    }

    PointRows read() {
        PointRows rows = header_.data == PcdData::kAscii    ? read_text()
                         : header_.data == PcdData::kBinary ? read_binary()
                                                            : read_compressed();
        rows.notes.insert(rows.notes.begin(), header_.notes.begin(), header_.notes.end());
        rows.notes.insert(rows.notes.end(), columns_.notes.begin(), columns_.notes.end());
        // A viewpoint at the origin is what writers put down who know of none; but what has rows
        // and columns was seen by a camera.
        if (header_.viewpoint || header_.height > 1)
            face_sensor(rows, 0, rows.cloud.positions.size(), header_.viewpoint.value_or(Vec3d{}));
        if (header_.height > 1)
            rows.notes.push_back(fmt::format("organised, {} x {}: the sensor is at the VIEWPOINT",
                                             header_.width, header_.height));
        return rows;
    }

    std::string format() const { return fmt::format("PCD {}", to_string(header_.data)); }

 private:
    [[noreturn]] void fail_short(std::uint64_t num_there) const {
        fail(ErrorCode::kInvalidInput,
             "{}: the header promises {} points, but bytes are there for only {} (the file ends at "
             "byte {}): it is cut off, or the header is wrong",
             name_, header_.num_points, num_there, bytes_.size());
    }

    PointRows read_binary() {
        const std::size_t num_there = (bytes_.size() - header_.num_bytes) / header_.row_bytes;
        if (header_.num_points > num_there) fail_short(num_there);
        const std::byte* const begin = bytes_.data() + header_.num_bytes;
        return read_places(
            [&](const PcdField& field) { return Place{begin + field.offset, header_.row_bytes}; });
    }

    PointRows read_compressed() {
        const std::span<const std::byte> data = bytes_.subspan(header_.num_bytes);
        constexpr std::size_t kSizes = 8;
        if (data.size() < kSizes) fail_short(0);
        const auto num_packed = load_value<std::uint32_t>(data.data());
        const auto num_unpacked = load_value<std::uint32_t>(data.data() + 4);
        if (num_packed > data.size() - kSizes)
            fail(ErrorCode::kInvalidInput,
                 "{}: byte {}: {} compressed bytes are promised, but only {} are there: the file "
                 "is cut off",
                 name_, header_.num_bytes, num_packed, data.size() - kSizes);
        const std::uint64_t num_there = num_unpacked / header_.row_bytes;
        if (num_unpacked / kMostPerLzfByte > num_packed)
            fail(ErrorCode::kInvalidInput, "{}: byte {}: {} bytes cannot unpack to {}", name_,
                 header_.num_bytes, num_packed, num_unpacked);
        if (header_.num_points > num_there) fail_short(num_there);
        std::vector<std::byte> unpacked(num_unpacked);
        if (!unpack_lzf(data.subspan(kSizes, num_packed), unpacked))
            fail(ErrorCode::kInvalidInput,
                 "{}: the compressed data behind byte {} are damaged: they do not unpack to {} "
                 "bytes",
                 name_, header_.num_bytes, num_unpacked);
        const auto n = static_cast<std::size_t>(header_.num_points);
        return read_places([&](const PcdField& field) {
            return Place{unpacked.data() + field.offset * n, field.num_bytes()};
        });
    }

    /// Where a field's first value is, and how far it is to the next point's.
    struct Place {
        const std::byte* begin = nullptr;
        std::size_t stride = 0;
    };

    template <class PlaceOf>
    PointRows read_places(PlaceOf&& place_of) {
        table_.allocate(header_.num_points);
        const auto n = static_cast<std::size_t>(header_.num_points);
        parallel_for(context_, n, kBlockRows, [&](std::size_t begin, std::size_t end) {
            std::vector<std::vector<double>> values;
            for (const std::size_t column : table_.wanted()) {
                const Source& source = columns_.sources[column];
                const PcdField& field = header_.fields[source.field];
                const Place place = place_of(field);
                const std::byte* const from =
                    place.begin + begin * place.stride + source.component * size_of(field.type);
                values.emplace_back(end - begin);
                if (source.shift == kNotPacked) {
                    load_column(field.type, from, place.stride, false, values.back());
                    continue;
                }
                for (std::size_t i = 0; i < end - begin; ++i)
                    values.back()[i] = static_cast<double>(
                        load_value<std::uint32_t>(from + i * place.stride) >> source.shift & 255U);
            }
            store({begin, end - begin, {}}, values);
        });
        return table_.finish(context_);
    }

    void store(TableBlock block, const std::vector<std::vector<double>>& values) {
        for (const std::vector<double>& column : values) block.columns.emplace_back(column);
        table_.store(block);
    }

    /// Place of a source's value in a row of text.
    std::size_t text_column(const Source& source) const {
        std::size_t column = source.component;
        for (std::size_t i = 0; i < source.field; ++i) column += header_.fields[i].count;
        return column;
    }

    PointRows read_text() {
        const TextSource source{name_, text_, '\n'};
        std::string_view text = text_.substr(header_.num_bytes);
        const TextRows all(text, '\n', context_);
        if (all.num_rows() < header_.num_points) fail_short(all.num_rows());
        // Each value takes a byte at least.
        if (header_.row_values > text.size()) fail_short(0);
        const auto n = static_cast<std::size_t>(header_.num_points);
        if (all.num_rows() > n) text = text.substr(0, all.byte_of_row(n));
        const TextRows rows(text, '\n', context_);

        // Several columns may come from one of the text.
        std::vector<std::size_t> text_columns;
        for (const std::size_t column : table_.wanted())
            text_columns.push_back(text_column(columns_.sources[column]));
        std::vector<std::size_t> distinct = text_columns;
        std::sort(distinct.begin(), distinct.end());
        distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());

        table_.allocate(n);
        BadRows bad;
        rows.read(header_.row_values, distinct, context_, [&](const TextBlock& block) {
            std::vector<std::vector<double>> values;
            for (std::size_t k = 0; k < text_columns.size(); ++k) {
                const auto at = std::lower_bound(distinct.begin(), distinct.end(), text_columns[k]);
                values.push_back(block.columns[static_cast<std::size_t>(at - distinct.begin())]);
                const Source& from = columns_.sources[table_.wanted()[k]];
                if (from.shift == kNotPacked) continue;
                const NumberType type = header_.fields[from.field].type;
                for (double& v : values.back())
                    v = static_cast<double>(packed_of(v, type) >> from.shift & 255U);
            }
            store({block.first_row, block.num_rows, {}}, values);
            bad.add(block);
        });
        PointRows points = table_.finish(context_);
        bad.drop_from(points, source, header_.row_values);
        return points;
    }

    std::span<const std::byte> bytes_;
    const std::string& name_;
    const Context& context_;
    std::string_view text_;
    PcdHeader header_;
    Columns columns_;
    PointTable table_;
};

}  // namespace

bool is_pcd(std::span<const std::byte> bytes) {
    constexpr std::size_t kLookAt = 4096;
    std::string_view text(reinterpret_cast<const char*>(bytes.data()),
                          std::min(bytes.size(), kLookAt));
    if (text.starts_with("# .PCD")) return true;
    while (!text.empty()) {
        const std::string_view line = take_line(text, '\n');
        if (line.empty() || line.front() == '#') continue;
        const std::string_view word = line.substr(0, line.find_first_of(" \t"));
        return word.size() < line.size() &&
               (word == "VERSION" || word == "FIELDS" || word == "COLUMNS");
    }
    return false;
}

LoadResult read_pcd(std::span<const std::byte> bytes, const std::filesystem::path& path,
                    const Context& context) {
    const std::string name = path.string();
    PcdReader reader(bytes, name, context);
    PointRows rows = reader.read();
    report_progress(context, "load", 0.5);
    LoadResult result = finish_cloud(std::move(rows), reader.format(), name, context).result;
    report_progress(context, "load", 1.0);
    return result;
}

}  // namespace pointbake
