// A scan is: columns, rows; the scanner's position; its three axes; a matrix of four lines, by
// which a point is multiplied as a row (x y z 1), so that the last line is the translation; then a
// line per point: x y z, intensity, and perhaps red green blue. 0 0 0 means that nothing came back.
#include "io/read_ptx.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>

#include "core/message.h"
#include "core/parallel.h"
#include "io/finish_cloud.h"
#include "io/scanner.h"
#include "io/text_numbers.h"
#include "io/text_points.h"

namespace pointbake {
namespace {

constexpr std::size_t kCountRows = 2, kHeaderRows = 8;  // one after the other

struct Scan {
    std::string_view text;  ///< of its points
    std::uint64_t num_points = 0;
    std::size_t first_row = 0;  ///< among the points of all scans
    std::size_t num_columns = 0;
    Vec3d scanner;
    std::array<Vec3d, 4> matrix;  ///< three axes and the translation
};

std::vector<double> numbers_of(std::string_view line) {
    std::vector<double> numbers;
    double value = 0.0;
    for (Fields fields(line); !fields.at_end() && fields.number(value);) numbers.push_back(value);
    return numbers;
}

/// The next line that is not blank.
std::string_view next_line(std::string_view& text, char line_end) {
    while (!text.empty())
        if (const std::string_view line = take_line(text, line_end); !line.empty()) return line;
    return {};
}

/// Takes the header of a scan off `text`; nothing if it is none.
std::optional<Scan> take_header(std::string_view& text, char line_end) {
    Scan scan;
    std::array<double, 2> counts{};
    for (double& count : counts) {
        const std::string_view line = next_line(text, line_end);
        if (!is_text_count(line) || !NumberReader(line).next(count)) return std::nullopt;
    }
    // Each alone, too: the other may be zero.
    constexpr double kMostPoints = 1e18;
    if (!(std::max({counts[0], counts[1], counts[0] * counts[1]}) < kMostPoints))
        return std::nullopt;
    scan.num_points = static_cast<std::uint64_t>(counts[0]) * static_cast<std::uint64_t>(counts[1]);
    for (std::size_t k = 0; k < kHeaderRows; ++k) {
        const std::vector<double> numbers = numbers_of(next_line(text, line_end));
        if (numbers.size() != (k < 4 ? 3U : 4U)) return std::nullopt;
        const Vec3d v{numbers[0], numbers[1], numbers[2]};
        if (!is_finite(v)) return std::nullopt;
        if (k == 0) scan.scanner = v;
        if (k >= 4) scan.matrix[k - 4] = v;
    }
    return scan;
}

class PtxReader {
 public:
    PtxReader(std::string_view text, const std::filesystem::path& path, const Context& context)
        : source_{path.string(), text, line_end_of(text)}, context_(context) {
        find_scans();
    }

    PointRows read() {
        const auto have = [&](std::size_t at_least) {
            return std::all_of(scans_.begin(), scans_.end(),
                               [&](const Scan& s) { return s.num_columns >= at_least; });
        };
        std::vector<TableColumn> columns{{"x"}, {"y"}, {"z"}};
        if (have(4)) columns.push_back({"intensity"});
        if (have(7))
            for (const char* name : {"red", "green", "blue"})
                columns.push_back({name, NumberType::kInt32});
        PointTable table(columns, source_.name, "the scans have no");
        table.allocate(num_points_);
        is_empty_.assign(num_points_, 0);
        BadRows bad;
        for (const Scan& scan : scans_) read_scan(scan, table, bad);
        PointRows points = table.finish(context_);
        bad.drop_from(points, source_, scans_[0].num_columns);
        drop_no_returns(points, is_empty_, "row", "0 0 0");
        for (const Scan& scan : scans_) add_sensor(scan, points);
        points.notes.push_back(fmt::format(
            "{}{}", counted(scans_.size(), "scan"),
            columns.size() < 7 && std::any_of(scans_.begin(), scans_.end(),
                                              [](const Scan& s) { return s.num_columns >= 7; })
                ? ": colours left out, not all have them"
                : ""));
        return points;
    }

 private:
    void find_scans() {
        const TextRows all(source_.text, source_.line_end, context_);
        std::string_view rest = source_.text;
        if (all.num_rows() == 0) fail_header(rest);
        std::size_t row = 0;  // of all rows, headers included
        while (row < all.num_rows()) {
            const std::string_view begin = rest;
            std::optional<Scan> scan = take_header(rest, source_.line_end);
            if (!scan) fail_header(begin);
            row += kCountRows + kHeaderRows;
            if (scan->num_points > all.num_rows() - row)
                fail(ErrorCode::kInvalidInput,
                     "{}: the header of scan {} promises {} points, but lines are there for only "
                     "{}: the file is cut off, or the header is wrong",
                     source_.place(begin), scans_.size() + 1, scan->num_points,
                     all.num_rows() - row);
            const auto n = static_cast<std::size_t>(scan->num_points);
            row += n;
            const auto from = static_cast<std::size_t>(rest.data() - source_.text.data());
            const std::size_t to = end_of_rows(rest, n, row, all);
            scan->text = source_.text.substr(from, to - from);
            scan->first_row = num_points_;
            num_points_ += n;
            rest = source_.text.substr(to);
            if (n == 0) continue;
            find_columns(*scan);
            scans_.push_back(*scan);
        }
        if (scans_.empty()) fail(ErrorCode::kEmpty, "{}: the file holds 0 points", source_.name);
    }

    /// Where `n` rows end that `rest` begins with; `row` is the one behind them. Few are walked
    /// over, many are looked up.
    std::size_t end_of_rows(std::string_view rest, std::size_t n, std::size_t row,
                            const TextRows& all) const {
        constexpr std::size_t kFew = 4096;
        if (n > kFew) {
            rest = source_.text.substr(all.byte_of_row(row - 1));
            n = 1;
        }
        while (n > 0) n -= is_text_row(take_line(rest, source_.line_end));
        return static_cast<std::size_t>(rest.data() - source_.text.data());
    }

    [[noreturn]] void fail_header(std::string_view at) const {
        while (!at.empty()) {
            std::string_view rest = at;
            if (!take_line(rest, source_.line_end).empty()) break;
            at = rest;
        }
        fail(ErrorCode::kInvalidInput,
             "{}: no header of a scan: two counts, four lines of three numbers and four of four "
             "are wanted; the scan before may have more points than its header says",
             source_.place(at));
    }

    void find_columns(Scan& scan) const {
        std::string_view rest = scan.text;
        const std::string_view line = next_line(rest, source_.line_end);
        scan.num_columns = numbers_of(line).size();
        if (scan.num_columns != 3 && scan.num_columns != 4 && scan.num_columns != 7)
            fail(ErrorCode::kInvalidInput,
                 "{}: {} numbers; x y z, intensity, and perhaps red green blue are wanted",
                 source_.place(line), scan.num_columns);
    }

    void read_scan(const Scan& scan, PointTable& table, BadRows& bad) {
        // Of what the scan has, the columns that the table wants: its first ones.
        const std::vector<std::size_t>& wanted = table.wanted();
        const std::array<Vec3d, 4>& m = scan.matrix;
        TextRows(scan.text, source_.line_end, context_)
            .read(scan.num_columns, wanted, context_, [&](const TextBlock& block) {
                std::vector<std::vector<double>> columns = block.columns;
                TableBlock part{scan.first_row + block.first_row, block.num_rows, {}};
                for (std::size_t i = 0; i < block.num_rows; ++i) {
                    const Vec3d p{columns[0][i], columns[1][i], columns[2][i]};
                    if (p == Vec3d{}) is_empty_[part.first_row + i] = 1;
                    const Vec3d q = m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
                    for (std::size_t k = 0; k < 3; ++k) columns[k][i] = q[k];
                }
                for (const std::vector<double>& column : columns) part.columns.emplace_back(column);
                table.store(part);
                bad.add(block, scan.first_row);
            });
    }

    /// Where the scanner stood, if that is known: files whose points were moved elsewhere before
    /// they were written have a matrix that does nothing, and a scanner far from all points.
    void add_sensor(const Scan& scan, PointRows& points) const {
        const std::size_t end = scan.first_row + static_cast<std::size_t>(scan.num_points);
        const Vec3d sensor = scan.matrix[3] == Vec3d{} ? scan.scanner : scan.matrix[3];
        add_scanner(points, scan.first_row, end, sensor);
    }

    TextSource source_;
    const Context& context_;
    std::vector<Scan> scans_;
    std::size_t num_points_ = 0;
    std::vector<std::uint8_t> is_empty_;  ///< per row: 0 0 0
};

}  // namespace

bool is_ptx(std::string_view text) {
    constexpr std::size_t kLookAt = 4096;
    const char line_end = line_end_of(text);
    std::string_view begin = text.substr(0, kLookAt);
    return take_header(begin, line_end).has_value();
}

LoadResult read_ptx(std::string_view text, const std::filesystem::path& path,
                    const Context& context) {
    PointRows rows = PtxReader(text, path, context).read();
    report_progress(context, "load", 0.5);
    LoadResult result = finish_cloud(std::move(rows), "PTX", path.string(), context).result;
    report_progress(context, "load", 1.0);
    return result;
}

}  // namespace pointbake
