// Columns without names are told by what a sample of the rows holds; when the other rows turn out
// to hold something else, they are read once more under other names.
#include "io/read_text.h"

#include <algorithm>
#include <array>

#include "core/message.h"
#include "core/parallel.h"
#include "io/finish_cloud.h"
#include "io/input_file.h"
#include "io/text_points.h"

namespace pointbake {
namespace {

enum class NamedBy { kOption, kHeader, kContent };

class TextReader {
 public:
    TextReader(std::string_view text, const TextLayout& layout, const std::filesystem::path& path,
               const Context& context)
        : layout_(layout),
          source_{path.string(), text, layout.line_end},
          extension_(kind_extension(path)),
          context_(context),
          body_(text.substr(layout.begin, layout.end - layout.begin)),
          rows_(body_, layout.line_end, context, layout.syntax) {
        for (std::size_t k = 0; k < layout.num_columns; ++k)
            if (layout.is_number[k]) numbers_.push_back(k);
    }

    PointRows read(const LoadOptions& options) {
        constexpr double kMost = 9e18;
        const auto num_promised = static_cast<std::size_t>(std::min(rows_.promised(), kMost));
        if (extension_ == ".pwn" && layout_.num_columns == 3 && num_promised > 0 &&
            rows_.num_rows() == 2 * num_promised)
            return points_then_normals(num_promised);
        PointRows points = !options.columns.empty() ? read_named_by_option(options.columns)
                           : !layout_.names.empty() ? read_named(layout_.names, NamedBy::kHeader)
                                                    : read_named_by_content();
        if (rows_.promised() > 0.0 && num_promised != rows_.num_rows())
            points.notes.push_back(fmt::format("{} promised, but {} there",
                                               counted(num_promised, "point"),
                                               counted(rows_.num_rows(), "row")));
        return points;
    }

    const std::string& guess() const { return guess_; }
    std::string format() const { return fmt::format("text, {} columns", layout_.num_columns); }

 private:
    PointRows read_named_by_option(std::string_view columns) {
        std::vector<std::string> names = parse_columns(columns);
        if (names.size() > layout_.num_columns)
            fail(ErrorCode::kInvalidOption, "columns: {} are named, but {} has {}", names.size(),
                 source_.name, layout_.num_columns);
        names.resize(layout_.num_columns);
        return read_named(names, NamedBy::kOption);
    }

    PointRows read_named_by_content() {
        // Lines like "v 1 2 3" and "n 0 0 1" look like a table, but are none.
        if (numbers_[2] != 2)
            fail(ErrorCode::kInvalidInput,
                 "{}: words among the first three of {} columns; name the columns with --columns, "
                 "like -,x,y,z",
                 source_.name, layout_.num_columns);
        ColumnStats stats(numbers_.size());
        // The first block is the sample.
        std::string_view sample = cut_sample();
        TextRows(sample, layout_.line_end, context_, layout_.syntax)
            .read(layout_.num_columns, numbers_, context_,
                  [&](const TextBlock& block) { stats.add(block.columns, block.has_point); });
        std::vector<std::string> names = names_of(stats);
        for (;;) {
            ColumnStats all(numbers_.size());
            PointRows points = read_named(names, NamedBy::kContent, &all);
            std::vector<std::string> better = names_of(all);
            if (better == names) return points;
            names = std::move(better);  // all rows are known: the next round is the last
        }
    }

    /// Whole lines at the beginning.
    std::string_view cut_sample() const {
        constexpr std::size_t kBytes = std::size_t{1} << 16;
        if (body_.size() <= kBytes) return body_;
        const std::size_t end = body_.find(layout_.line_end, kBytes);
        return body_.substr(0, end == std::string_view::npos ? end : end + 1);
    }

    /// Per column of the file.
    std::vector<std::string> names_of(const ColumnStats& stats) const {
        const std::vector<std::string> found =
            names_by_content(stats, numbers_.size(),
                             {.has_intensity_first = extension_ == ".pts",
                              .has_normals = extension_ == ".xyzn" || extension_ == ".pwn"});
        std::vector<std::string> names(layout_.num_columns);
        for (std::size_t k = 0; k < numbers_.size(); ++k) names[numbers_[k]] = found[k];
        return names;
    }

    /// Columns with a name that hold numbers.
    std::vector<std::size_t> columns_named(const std::vector<std::string>& names) const {
        std::vector<std::size_t> columns;
        for (std::size_t k = 0; k < names.size(); ++k)
            if (!names[k].empty() && layout_.is_number[k]) columns.push_back(k);
        for (std::size_t k = 0; k < names.size(); ++k)
            if (!layout_.is_number[k] && is_coordinate(names[k]))
                fail(ErrorCode::kInvalidInput,
                     "{}: column '{}' holds no numbers in most of the first rows", source_.name,
                     names[k]);
        return columns;
    }

    static bool is_coordinate(std::string_view name) {
        constexpr std::string_view kNames = "xyzXYZ";
        return name.size() == 1 && kNames.find(name[0]) != std::string_view::npos;
    }

    PointRows read_named(const std::vector<std::string>& names, NamedBy by,
                         ColumnStats* all = nullptr) {
        const std::vector<std::size_t> columns = columns_named(names);
        std::vector<TableColumn> table_columns;
        for (const std::size_t k : columns) table_columns.push_back({names[k]});
        PointTable table(table_columns, source_.name, "the columns have no");
        table.allocate(rows_.num_rows());
        std::vector<std::size_t> place_of_wanted;  // among the columns read
        for (const std::size_t wanted : table.wanted()) place_of_wanted.push_back(wanted);

        std::vector<ColumnStats> stats(rows_.num_blocks(), ColumnStats(columns.size()));
        BadRows bad;
        rows_.read(layout_.num_columns, columns, context_, [&](const TextBlock& block) {
            TableBlock part{block.first_row, block.num_rows, {}};
            for (const std::size_t k : place_of_wanted) part.columns.emplace_back(block.columns[k]);
            table.store(part);
            stats[block.index].add(block.columns, block.has_point);
            bad.add(block);
        });
        ColumnStats sum(columns.size());
        for (const ColumnStats& part : stats) sum.add(part);
        for (std::size_t k = 0; k < columns.size(); ++k)
            if (sum.is_whole(k)) table.set_type(k, NumberType::kInt64);
        PointRows points = table.finish(context_);
        bad.drop_from(points, source_, layout_.num_columns);
        if (all != nullptr) *all = sum;
        note_columns(names, by, points.notes);
        return points;
    }

    void note_columns(const std::vector<std::string>& names, NamedBy by,
                      std::vector<std::string>& notes) {
        std::string text;
        for (std::size_t k = 0; k < names.size(); ++k) {
            const bool is_read = !names[k].empty() && layout_.is_number[k];
            text += (k == 0 ? "" : ",") + (is_read ? names[k] : "-");
        }
        constexpr std::array<std::string_view, 3> kReasons{
            "by --columns", "by the header line",
            "by what they hold (--columns names them otherwise)"};
        notes.push_back(
            fmt::format("columns are {}, {}", text, kReasons[static_cast<std::size_t>(by)]));
        if (by == NamedBy::kContent && names.size() > 3) guess_ = notes.back();
        if (by == NamedBy::kContent && !layout_.header.empty()) {
            constexpr std::size_t kLongest = 60;
            notes.push_back(fmt::format(
                "header line '{}' not used: it does not name each of {} columns",
                std::string_view(layout_.header).substr(0, kLongest), layout_.num_columns));
        }
    }

    /// The old PWN: a count, so many points, then their normals.
    PointRows points_then_normals(std::size_t num_points) {
        const std::size_t cut = rows_.byte_of_row(num_points);
        constexpr std::array<std::size_t, 3> kAll{0, 1, 2};
        PointRows points;
        points.cloud.positions.resize(num_points);
        points.cloud.normals.resize(num_points);
        BadRows bad;
        const auto read_half = [&](std::string_view half, auto&& store) {
            TextRows(half, layout_.line_end, context_, layout_.syntax)
                .read(3, kAll, context_, [&](const TextBlock& block) {
                    bad.add(block);
                    for (std::size_t i = 0; i < block.num_rows; ++i)
                        store(block.first_row + i,
                              Vec3d{block.columns[0][i], block.columns[1][i], block.columns[2][i]});
                });
        };
        read_half(body_.substr(0, cut),
                  [&](std::size_t row, Vec3d p) { points.cloud.positions[row] = p; });
        bad.drop_from(points, source_, 3);
        read_half(body_.substr(cut), [&](std::size_t row, Vec3d n) {
            const Vec3d unit = normalized(n);
            points.cloud.normals[row] = is_finite(unit) ? vec_cast<float>(unit) : Vec3f{};
        });
        points.notes.emplace_back("all points, then all normals");
        return points;
    }

    const TextLayout& layout_;
    std::string guess_;
    TextSource source_;
    std::string extension_;
    const Context& context_;
    std::string_view body_;
    TextRows rows_;
    std::vector<std::size_t> numbers_;  ///< columns that hold numbers
};

}  // namespace

PointRows read_text_points(std::string_view text, const TextLayout& layout,
                           const std::filesystem::path& path, const LoadOptions& options,
                           const Context& context) {
    return TextReader(text, layout, path, context).read(options);
}

LoadResult read_text(std::string_view text, const TextLayout& layout,
                     const std::filesystem::path& path, const LoadOptions& options,
                     const Context& context) {
    TextReader reader(text, layout, path, context);
    report_progress(context, "load", 0.1);
    PointRows rows = reader.read(options);
    report_progress(context, "load", 0.5);
    LoadResult result =
        finish_cloud(std::move(rows), reader.format(), path.string(), context).result;
    result.report.guess = reader.guess();
    report_progress(context, "load", 1.0);
    return result;
}

bool is_text_extension(std::string_view extension) {
    constexpr std::array<std::string_view, 8> kExtensions{".xyz", ".txt", ".csv",  ".asc",
                                                          ".pts", ".pwn", ".xyzn", ".xyzrgb"};
    return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

}  // namespace pointbake
