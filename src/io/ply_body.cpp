// Text goes through std::from_chars; binary values are copied out column by column.
#include "io/ply_body.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "core/message.h"
#include "core/parallel.h"
#include "io/text_numbers.h"

namespace pointbake {
namespace {

constexpr std::size_t kBlockRows = 4096;  // a block's columns stay in the second-level cache
constexpr std::size_t kRowsPerPoll = std::size_t{1} << 16;

bool needs_swap(PlyFormat format) {
    return (format == PlyFormat::kLittleEndian) != (std::endian::native == std::endian::little);
}

/// Which of the wanted columns each property goes to.
constexpr std::size_t kUnwanted = ~std::size_t{0};
std::vector<std::size_t> column_of_property(const PlyElement& element,
                                            std::span<const std::size_t> properties) {
    std::vector<std::size_t> column(element.properties.size(), kUnwanted);
    for (std::size_t i = 0; i < properties.size(); ++i) column[properties[i]] = i;
    return column;
}

std::string what(const PlyElement& element) {
    if (element.name == "vertex") return "points";
    if (element.name == "face") return "faces";
    return fmt::format("rows of '{}'", element.name);
}

}  // namespace

PlyBody::PlyBody(std::span<const std::byte> bytes, const PlyHeader& header,
                 std::size_t num_elements, const std::string& path, const Context& context)
    : bytes_(bytes), header_(header), path_(path), places_(num_elements) {
    if (header.format == PlyFormat::kAscii) {
        cut_text(context);
        place_text_rows();
    } else {
        place_binary_rows(num_elements, context);
    }
}

void PlyBody::fail_short(const PlyElement& element, std::uint64_t num_there) const {
    fail(ErrorCode::kInvalidInput,
         "{}: the header promises {} {}, but bytes are there for only {} (the file ends at byte "
         "{}): it is cut off, or the header is wrong",
         path_, element.count, what(element), num_there, bytes_.size());
}

void PlyBody::cut_text(const Context& context) {
    const char* text = reinterpret_cast<const char*>(bytes_.data());
    const std::string_view all(text, bytes_.size());
    for (const std::string_view part :
         pointbake::cut_text(all.substr(header_.num_bytes), header_.line_end)) {
        const auto begin = static_cast<std::size_t>(part.data() - text);
        chunks_.push_back({begin, begin + part.size(), 0, 0});
    }
    parallel_for(context, chunks_.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            TextLines lines({text + chunks_[i].begin, text + chunks_[i].end}, header_.line_end);
            while (lines.next()) ++chunks_[i].num_rows;
        }
    });
}

void PlyBody::place_text_rows() {
    std::size_t num_rows = 0;
    for (Chunk& chunk : chunks_) {
        chunk.first_row = num_rows;
        num_rows += chunk.num_rows;
    }
    std::size_t row = 0;
    for (std::size_t i = 0; i < places_.size(); ++i) {
        const PlyElement& element = header_.elements[i];
        places_[i].begin = row;
        if (element.properties.empty()) continue;  // its rows would be blank lines
        if (element.count > num_rows - row) fail_short(element, num_rows - row);
        row += static_cast<std::size_t>(element.count);
    }
}

void PlyBody::place_binary_rows(std::size_t num_elements, const Context& context) {
    std::size_t position = header_.num_bytes;
    for (std::size_t i = 0; i < num_elements; ++i) {
        const PlyElement& element = header_.elements[i];
        places_[i].begin = position;
        const std::size_t min_bytes = element.min_row_bytes();
        if (min_bytes == 0) continue;
        const std::size_t max_rows = (bytes_.size() - position) / min_bytes;
        if (!element.has_lists()) {
            if (element.count > max_rows) fail_short(element, max_rows);
            position += static_cast<std::size_t>(element.count) * min_bytes;
        } else {
            position = skip_list_rows(element, places_[i], context);
        }
    }
}

/// Walks over rows of different lengths; returns where they end.
std::size_t PlyBody::skip_list_rows(const PlyElement& element, Place& place,
                                    const Context& context) const {
    struct Step {
        std::size_t fixed = 0;  ///< bytes before the list
        NumberType count{};
        std::size_t item = 0;  ///< bytes per value of the list
    };
    std::vector<Step> steps(1);
    for (const PlyProperty& p : element.properties) {
        if (p.is_list()) {
            steps.back().count = *p.count_type;
            steps.back().item = size_of(p.type);
            steps.emplace_back();
        } else {
            steps.back().fixed += size_of(p.type);
        }
    }
    const bool swap = needs_swap(header_.format);
    std::size_t position = place.begin;
    for (std::uint64_t row = 0; row < element.count; ++row) {
        if (row % kRowsPerPoll == 0) check_cancelled(context);
        if (row % kBlockRows == 0) place.blocks.push_back(position);
        for (const Step& step : steps) {
            const std::size_t count_bytes = step.item == 0 ? 0 : size_of(step.count);
            if (bytes_.size() - position < step.fixed + count_bytes) fail_short(element, row);
            position += step.fixed;
            if (step.item == 0) continue;
            const double count = load_as_double(step.count, bytes_.data() + position, swap);
            if (count < 0.0)
                fail(ErrorCode::kInvalidInput, "{}: byte {}: a list of {} values in row {} of '{}'",
                     path_, position, count, row, element.name);
            position += count_bytes;
            const auto num_values = static_cast<std::size_t>(count);  // at most 2^32
            if (num_values > (bytes_.size() - position) / step.item) fail_short(element, row);
            position += num_values * step.item;
        }
    }
    return position;
}

std::pair<std::size_t, std::size_t> PlyBody::text_chunks(std::size_t element) const {
    const std::size_t begin = places_[element].begin;
    const std::size_t end = begin + static_cast<std::size_t>(header_.elements[element].count);
    const auto starts_after = [](std::size_t row, const Chunk& chunk) {
        return row < chunk.first_row + chunk.num_rows;
    };
    const auto first = std::upper_bound(chunks_.begin(), chunks_.end(), begin, starts_after);
    auto last = first;
    while (last != chunks_.end() && last->first_row < end) ++last;
    return {static_cast<std::size_t>(first - chunks_.begin()),
            static_cast<std::size_t>(last - chunks_.begin())};
}

std::size_t PlyBody::num_blocks(std::size_t element) const {
    const PlyElement& e = header_.elements[element];
    if (e.count == 0 || e.properties.empty()) return 0;
    if (header_.format == PlyFormat::kAscii) {
        const auto [first, last] = text_chunks(element);
        return last - first;
    }
    return (static_cast<std::size_t>(e.count) + kBlockRows - 1) / kBlockRows;
}

void PlyBody::read(std::size_t element, std::span<const std::size_t> properties,
                   const Context& context, const std::function<void(const PlyBlock&)>& body) const {
    const PlyElement& e = header_.elements[element];
    const Place& place = places_[element];
    const bool is_text = header_.format == PlyFormat::kAscii;
    const bool has_lists = e.has_lists();
    const std::size_t first_chunk = is_text ? text_chunks(element).first : 0;
    parallel_chunks(context, num_blocks(element), [&](std::size_t index) {
        PlyBlock block;
        block.index = index;
        block.columns.resize(properties.size());
        if (is_text) {
            read_text(e, place, chunks_[first_chunk + index], properties, block);
        } else {
            block.first_row = index * kBlockRows;
            block.num_rows =
                std::min(kBlockRows, static_cast<std::size_t>(e.count) - block.first_row);
            if (has_lists)
                read_lists(e, place, properties, block);
            else
                read_fixed(e, place, properties, block);
        }
        body(block);
    });
}

void PlyBody::read_fixed(const PlyElement& element, const Place& place,
                         std::span<const std::size_t> properties, PlyBlock& block) const {
    const bool swap = needs_swap(header_.format);
    const std::size_t stride = element.min_row_bytes();
    for (std::size_t k = 0; k < properties.size(); ++k) {
        std::size_t offset = 0;
        for (std::size_t p = 0; p < properties[k]; ++p)
            offset += size_of(element.properties[p].type);
        const std::byte* from = bytes_.data() + place.begin + block.first_row * stride + offset;
        std::vector<double>& to = block.columns[k].values;
        to.resize(block.num_rows);
        load_column(element.properties[properties[k]].type, from, stride, swap, to);
    }
}

/// Bounds were checked by skip_list_rows.
void PlyBody::read_lists(const PlyElement& element, const Place& place,
                         std::span<const std::size_t> properties, PlyBlock& block) const {
    const bool swap = needs_swap(header_.format);
    const std::vector<std::size_t> column = column_of_property(element, properties);
    const std::byte* from = bytes_.data() + place.blocks[block.index];
    for (std::size_t row = 0; row < block.num_rows; ++row) {
        for (std::size_t p = 0; p < column.size(); ++p) {
            const PlyProperty& property = element.properties[p];
            const std::size_t item = size_of(property.type);
            std::size_t num_values = 1;
            if (property.is_list()) {
                num_values =
                    static_cast<std::size_t>(load_as_double(*property.count_type, from, swap));
                from += size_of(*property.count_type);
            }
            if (column[p] != kUnwanted) {
                PlyColumn& to = block.columns[column[p]];
                for (std::size_t i = 0; i < num_values; ++i)
                    to.values.push_back(load_as_double(property.type, from + i * item, swap));
                if (property.is_list()) to.ends.push_back(to.values.size());
            }
            from += num_values * item;
        }
    }
}

void PlyBody::read_text(const PlyElement& element, const Place& place, const Chunk& chunk,
                        std::span<const std::size_t> properties, PlyBlock& block) const {
    const char* text = reinterpret_cast<const char*>(bytes_.data());
    const std::vector<std::size_t> column = column_of_property(element, properties);
    // The chunk may begin before the element and end after it.
    const std::size_t element_end = place.begin + static_cast<std::size_t>(element.count);
    const std::size_t begin = std::max(chunk.first_row, place.begin);
    const std::size_t end = std::min(chunk.first_row + chunk.num_rows, element_end);
    block.first_row = begin - place.begin;
    block.num_rows = end - begin;
    for (std::size_t k = 0; k < properties.size(); ++k)
        if (!element.properties[properties[k]].is_list())
            block.columns[k].values.reserve(block.num_rows);

    TextLines lines({text + chunk.begin, text + chunk.end}, header_.line_end);
    for (std::size_t row = chunk.first_row; row < end && lines.next(); ++row) {
        if (row < begin) continue;
        NumberReader numbers(lines.line());
        const auto fail_here = [&](std::string_view problem) {
            const auto line = header_.num_lines + 1 +
                              static_cast<std::size_t>(std::count(
                                  text + header_.num_bytes, lines.line().data(), header_.line_end));
            fail(ErrorCode::kInvalidInput, "{}:{}: {} in row {} of '{}'; the header wants {} {}",
                 path_, line, problem, row - place.begin, element.name, element.properties.size(),
                 element.has_lists() ? "numbers or lists" : "numbers");
        };
        for (std::size_t p = 0; p < column.size(); ++p) {
            PlyColumn* to = column[p] == kUnwanted ? nullptr : &block.columns[column[p]];
            double value = 0.0;
            std::size_t num_values = 1;
            if (element.properties[p].is_list() && numbers.at_end()) {
                num_values = 0;  // some writers leave empty lists out
            } else if (element.properties[p].is_list()) {
                if (!numbers.next(value)) fail_here(numbers.problem());
                if (!(value >= 0.0 && value <= 4294967295.0)) fail_here("a list with a bad count");
                num_values = static_cast<std::size_t>(value);
            }
            for (std::size_t i = 0; i < num_values; ++i) {
                if (to == nullptr ? !numbers.skip() : !numbers.next(value))
                    fail_here(numbers.problem());
                if (to != nullptr) to->values.push_back(value);
            }
            if (to != nullptr && element.properties[p].is_list())
                to->ends.push_back(to->values.size());
        }
        if (!numbers.at_end()) fail_here("too many values");
    }
}

}  // namespace pointbake
