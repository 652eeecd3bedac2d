// The numbers are offsets in the header as ASPRS's LAS Specification 1.4-R15 has them.
#include "io/las_header.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/message.h"
#include "io/crs.h"

namespace pointbake {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kLeastHeader = 227;  // of 1.0 to 1.2
constexpr std::size_t kHeaderOf14 = 375;   // has the count of 64 bits and the extended records
constexpr std::size_t kVlrBytes = 54;      // header of a variable length record
constexpr std::size_t kEvlrBytes = 60;     // of an extended one
constexpr std::size_t kUserIdBytes = 16;
constexpr std::uint16_t kExtraBytesRecord = 4;
constexpr std::uint16_t kLazRecord = 22204;
constexpr std::uint16_t kWktRecord = 2112, kGeoKeysRecord = 34735, kGeoTextsRecord = 34737;

std::string text_at(Bytes bytes, std::size_t at, std::size_t most) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data() + at), most);
    return std::string(text.substr(0, text.find('\0')));
}

/// A variable length record, whatever the kind of its header.
struct Record {
    std::string user_id;
    std::uint16_t id = 0;
    Bytes data;
};

class HeaderReader {
 public:
    HeaderReader(Bytes bytes, const std::string& name) : bytes_(bytes), name_(name) {}

    LasHeader read() {
        read_layout();
        read_count();
        read_scale();
        read_records();
        read_extended_records();
        find_crs();
        return std::move(header_);
    }

 private:
    template <class T>
    T value(std::size_t at) const {
        return load_value<T>(bytes_.data() + at);
    }

    void read_layout() {
        if (bytes_.size() < kLeastHeader)
            fail(ErrorCode::kInvalidInput,
                 "{}: the header is cut off at byte {}; it has {} bytes at least", name_,
                 bytes_.size(), kLeastHeader);
        const int major = value<std::uint8_t>(24);
        header_.minor_version = value<std::uint8_t>(25);
        constexpr int kNewest = 5;
        if (major != 1 || header_.minor_version > kNewest)
            fail(ErrorCode::kUnsupported, "{}: LAS of version {}.{}; 1.0 to 1.{} are read", name_,
                 major, header_.minor_version, kNewest);
        const auto header_bytes = value<std::uint16_t>(94);
        header_.points_at = value<std::uint32_t>(96);
        if (header_bytes < least_header() || header_bytes > bytes_.size())
            fail(ErrorCode::kInvalidInput,
                 "{}: byte 94: a header of {} bytes; version 1.{} has {} at least, and the file "
                 "has {}",
                 name_, header_bytes, header_.minor_version, least_header(), bytes_.size());
        if (header_.points_at < header_bytes || header_.points_at > bytes_.size())
            fail(ErrorCode::kInvalidInput,
                 "{}: byte 96: the points are said to begin at byte {}; the header ends at byte "
                 "{}, the file at byte {}",
                 name_, header_.points_at, header_bytes, bytes_.size());
        records_at_ = header_bytes;
        read_format();
    }

    std::size_t least_header() const {
        return header_.minor_version >= 4 ? kHeaderOf14 : kLeastHeader;
    }

    void read_format() {
        const auto format = value<std::uint8_t>(104);
        header_.is_compressed = (format & 0x80U) != 0;
        header_.point_format = format & 0x3f;  // LASzip marks compression in the two upper bits
        constexpr int kLast = 10;
        if (header_.point_format > kLast)
            fail(ErrorCode::kUnsupported, "{}: byte 104: point format {}; 0 to {} are read", name_,
                 header_.point_format, kLast);
        header_.record_bytes = value<std::uint16_t>(105);
        const std::size_t least = las_record_bytes(header_.point_format);
        if (header_.record_bytes < least)
            fail(ErrorCode::kInvalidInput,
                 "{}: byte 105: records of {} bytes; those of point format {} have {} at least",
                 name_, header_.record_bytes, header_.point_format, least);
    }

    /// Since 1.4 the count of 32 bits is there for old programs only and is often wrong.
    void read_count() {
        const auto legacy = value<std::uint32_t>(107);
        header_.num_points = legacy;
        if (header_.minor_version >= 4) {
            header_.num_points = value<std::uint64_t>(247);
            if (header_.num_points == 0 && legacy > 0) {
                header_.num_points = legacy;
                header_.notes.emplace_back(
                    "the count of 64 bits is 0: the one of 32 bits is taken");
            }
        }
        if (header_.num_points == 0) fail(ErrorCode::kEmpty, "{}: the file holds 0 points", name_);
    }

    void read_scale() {
        for (std::size_t k = 0; k < 3; ++k) {
            header_.scale[k] = value<double>(131 + 8 * k);
            header_.offset[k] = value<double>(155 + 8 * k);
            if (!std::isfinite(header_.scale[k]) || header_.scale[k] == 0.0 ||
                !std::isfinite(header_.offset[k]))
                fail(ErrorCode::kInvalidInput,
                     "{}: byte {}: coordinates are scaled by {} and moved by {}; finite numbers "
                     "are wanted, and a scale that is not 0",
                     name_, 131 + 8 * k, header_.scale[k], header_.offset[k]);
        }
    }

    /// Their count is not believed: the records must end before the points.
    void read_records() {
        const auto num_records = value<std::uint32_t>(100);
        std::size_t at = records_at_;
        for (std::uint32_t i = 0; i < num_records; ++i) {
            const std::size_t room = header_.points_at - at;
            if (room < kVlrBytes) return note_records(i, num_records);
            const std::size_t length = value<std::uint16_t>(at + 20);
            if (length > room - kVlrBytes) return note_records(i, num_records);
            take({text_at(bytes_, at + 2, kUserIdBytes), value<std::uint16_t>(at + 18),
                  bytes_.subspan(at + kVlrBytes, length)});
            at += kVlrBytes + length;
        }
    }

    void note_records(std::uint32_t num_there, std::uint32_t num_promised) {
        header_.notes.push_back(
            fmt::format("{} of {} variable length records are there before the points", num_there,
                        num_promised));
    }

    void read_extended_records() {
        if (header_.minor_version < 4) return;
        const auto num_records = value<std::uint32_t>(243);
        auto at = value<std::uint64_t>(235);
        for (std::uint32_t i = 0; i < num_records; ++i) {
            if (at > bytes_.size() || bytes_.size() - at < kEvlrBytes)
                return note_extended(i, num_records);
            const auto from = static_cast<std::size_t>(at);
            const auto length = value<std::uint64_t>(from + 20);
            if (length > bytes_.size() - from - kEvlrBytes) return note_extended(i, num_records);
            take({text_at(bytes_, from + 2, kUserIdBytes), value<std::uint16_t>(from + 18),
                  bytes_.subspan(from + kEvlrBytes, static_cast<std::size_t>(length))});
            at += kEvlrBytes + length;
        }
    }

    void note_extended(std::uint32_t num_there, std::uint32_t num_promised) {
        header_.notes.push_back(
            fmt::format("{} of {} extended variable length records are there: the file may be cut "
                        "off behind its points",
                        num_there, num_promised));
    }

    void take(const Record& record) {
        if (record.user_id == "LASF_Spec" && record.id == kExtraBytesRecord && !has_extra_) {
            has_extra_ = true;
            read_extra(record.data);
        }
        if (record.user_id == "laszip encoded" && record.id == kLazRecord)
            header_.laz_vlr = record.data;
        if (record.user_id != "LASF_Projection") return;
        if (record.id == kWktRecord) wkt_ = record.data;
        if (record.id == kGeoKeysRecord) geo_keys_ = record.data;
        if (record.id == kGeoTextsRecord) geo_texts_ = record.data;
    }

    /// Many writers put down both kinds, whatever the header says of them: WKT tells more.
    void find_crs() {
        const auto text = [](Bytes bytes) {
            return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        };
        header_.frame.up = UpAxis::kZ;
        std::string note = add_crs(header_.frame, text(wkt_));
        if (header_.frame.crs.name.empty() && !geo_keys_.empty())
            note = add_crs(header_.frame, geo_keys_, text(geo_texts_));
        if (!note.empty()) header_.notes.push_back(std::move(note));
    }

    /// A descriptor per field, as far as the record has bytes for them.
    void read_extra(Bytes descriptors) {
        constexpr std::size_t kBytes = 192;
        std::size_t at = las_record_bytes(header_.point_format);
        for (; descriptors.size() >= kBytes; descriptors = descriptors.subspan(kBytes)) {
            const Bytes d = descriptors.first(kBytes);
            const auto type = std::to_integer<std::size_t>(d[2]);
            const auto options = std::to_integer<std::size_t>(d[3]);
            if (type == 0) {  // so many bytes of unknown meaning
                at += options;
                continue;
            }
            if (type > kTypes.size() * kMostComponents) return note_extra(d);
            const NumberType number = kTypes[(type - 1) % kTypes.size()];
            const std::size_t count = (type - 1) / kTypes.size() + 1;
            if (at + count * size_of(number) > header_.record_bytes) return note_extra(d);
            for (std::size_t k = 0; k < count; ++k) {
                add_extra(d, number, at, count == 1 ? kWhole : k);
                at += size_of(number);
            }
        }
    }

    void note_extra(Bytes descriptor) {
        header_.notes.push_back(fmt::format(
            "extra bytes from '{}' on ignored: of an unknown type, or beyond the records of {} "
            "bytes",
            text_at(descriptor, kNameAt, kNameBytes), header_.record_bytes));
    }

    /// Component k of a field; those of vectors are an old kind, whose names get numbers.
    void add_extra(Bytes descriptor, NumberType type, std::size_t at, std::size_t k) {
        constexpr std::size_t kNoDataAt = 40, kScaleAt = 112, kOffsetAt = 136;
        constexpr unsigned kHasNoData = 1, kHasScale = 8, kHasOffset = 16;
        const auto options = std::to_integer<unsigned>(descriptor[3]);
        const std::size_t slot = 8 * (k == kWhole ? 0 : k);
        const auto number = [&](std::size_t from, NumberType of) {
            return load_as_double(of, descriptor.data() + from + slot);
        };
        LasField field;
        field.name = text_at(descriptor, kNameAt, kNameBytes);
        if (field.name.empty()) field.name = fmt::format("extra_{}", header_.extra.size());
        if (k != kWhole) field.name += fmt::format("_{}", k);
        field.type = type;
        field.at = at;
        if ((options & kHasScale) != 0) field.scale = number(kScaleAt, NumberType::kFloat64);
        if ((options & kHasOffset) != 0) field.offset = number(kOffsetAt, NumberType::kFloat64);
        if ((options & kHasNoData) != 0) field.no_data = number(kNoDataAt, wide(type));
        header_.extra.push_back(std::move(field));
    }

    /// Limits in a descriptor have eight bytes each, whatever the field has.
    static NumberType wide(NumberType type) {
        if (is_float(type)) return NumberType::kFloat64;
        const bool is_signed = type == NumberType::kInt8 || type == NumberType::kInt16 ||
                               type == NumberType::kInt32 || type == NumberType::kInt64;
        return is_signed ? NumberType::kInt64 : NumberType::kUint64;
    }

    static constexpr std::size_t kNameAt = 4, kNameBytes = 32;
    static constexpr std::size_t kMostComponents = 3, kWhole = kMostComponents;
    static constexpr std::array<NumberType, 10> kTypes{
        NumberType::kUint8,   NumberType::kInt8,   NumberType::kUint16, NumberType::kInt16,
        NumberType::kUint32,  NumberType::kInt32,  NumberType::kUint64, NumberType::kInt64,
        NumberType::kFloat32, NumberType::kFloat64};

    Bytes bytes_;
    const std::string& name_;
    LasHeader header_;
    std::size_t records_at_ = 0;
    bool has_extra_ = false;
    Bytes wkt_, geo_keys_, geo_texts_;
};

}  // namespace

std::size_t las_record_bytes(int point_format) {
    constexpr std::array<std::size_t, 11> kBytes{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
    return kBytes.at(static_cast<std::size_t>(point_format));
}

LasHeader read_las_header(Bytes bytes, const std::string& name) {
    return HeaderReader(bytes, name).read();
}

}  // namespace pointbake
