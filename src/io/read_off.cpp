// The keyword tells what a vertex has: ST texture coordinates, C colour, N normal; plain OFF with
// more columns than three is told by what they hold. A vertex and a polygon take a line each.
#include "io/read_off.h"

#include <array>
#include <cmath>
#include <optional>

#include "core/message.h"
#include "core/parallel.h"
#include "io/finish_cloud.h"
#include "io/read_text.h"
#include "io/text_points.h"

namespace pointbake {
namespace {

constexpr TextSyntax kSyntax{.ends_at_hash = true};
constexpr std::size_t kLinesPerPoll = std::size_t{1} << 16;

/// [ST][C][N][4][n]OFF
struct Keyword {
    bool has_colors = false, has_normals = false, is_4d = false;
    std::size_t size = 0;
};

std::optional<Keyword> keyword_of(std::string_view line) {
    Keyword keyword;
    std::string_view rest = line;
    const auto take = [&](std::string_view letters) {
        if (!rest.starts_with(letters)) return false;
        rest.remove_prefix(letters.size());
        return true;
    };
    take("ST");
    keyword.has_colors = take("C");
    keyword.has_normals = take("N");
    keyword.has_colors = keyword.has_colors || take("C");  // some write NCOFF
    keyword.is_4d = take("4");
    keyword.is_4d = take("n") || keyword.is_4d;
    if (!take("OFF")) return std::nullopt;
    if (!rest.empty() && rest[0] != ' ' && rest[0] != '\t') return std::nullopt;
    keyword.size = line.size() - rest.size();
    return keyword;
}

/// Names of a vertex' columns; none: to be told by content.
std::vector<std::string> vertex_names(const Keyword& keyword, std::size_t num_columns) {
    if (!keyword.has_colors && !keyword.has_normals) return {};
    std::vector<std::string> names = {"x", "y", "z"};
    if (keyword.has_normals) names.insert(names.end(), {"nx", "ny", "nz"});
    if (keyword.has_colors && names.size() + 3 <= num_columns)
        names.insert(names.end(), {"red", "green", "blue"});
    names.resize(num_columns);
    return names;
}

class OffReader {
 public:
    OffReader(std::string_view text, const std::filesystem::path& path, const Context& context)
        : path_(path), source_{path.string(), text, line_end_of(text)}, context_(context) {
        std::string_view rest = text;
        std::string_view line = next_line(rest);
        keyword_ = *keyword_of(line);
        if (keyword_.is_4d)
            fail(ErrorCode::kUnsupported, "{}: '{}': points of three dimensions are read",
                 source_.name, line.substr(0, keyword_.size));
        line.remove_prefix(keyword_.size);
        if (line.find("BINARY") != std::string_view::npos)
            fail(ErrorCode::kUnsupported, "{}: binary OFF is not read; save it as text",
                 source_.name);
        if (line.find_first_not_of(" \t") == std::string_view::npos) line = next_line(rest);
        read_counts(line);
        body_ = rest;
    }

    LoadResult read() {
        const TextRows rows(body_, source_.line_end, context_, kSyntax);
        check_count("vertices", num_vertices_, rows.num_rows());
        const std::size_t num_there = rows.num_rows() - num_vertices_;
        check_count("faces", num_faces_, num_there);
        if (num_vertices_ == 0)
            fail(ErrorCode::kEmpty, "{}: the file holds 0 points", source_.name);
        const std::size_t cut = rows.byte_of_row(num_vertices_);
        FinishedCloud finished =
            finish_cloud(read_vertices(body_.substr(0, cut)), "OFF", source_.name, context_);
        add_faces(body_.substr(cut), finished);
        if (num_there > num_faces_)
            finished.result.report.notes.push_back(
                fmt::format("{} behind the {} promised ignored",
                            counted(num_there - num_faces_, "line"), counted(num_faces_, "face")));
        return std::move(finished.result);
    }

 private:
    /// The next line that is neither blank nor a comment.
    std::string_view next_line(std::string_view& rest) const {
        while (!rest.empty()) {
            const std::string_view line = take_line(rest, source_.line_end);
            if (!line.empty() && line[0] != '#') return line;
        }
        return rest;
    }

    void read_counts(std::string_view line) {
        std::array<double, 2> counts{};
        Fields fields(line);
        for (double& count : counts) {
            constexpr double kMost = 1e15;
            if (!fields.number(count) || !(count >= 0.0 && count < kMost) ||
                count != std::floor(count))
                fail(ErrorCode::kInvalidInput,
                     "{}: the numbers of vertices and faces are wanted behind the keyword",
                     source_.place(line));
        }
        num_vertices_ = static_cast<std::size_t>(counts[0]);
        num_faces_ = static_cast<std::size_t>(counts[1]);
    }

    void check_count(std::string_view what, std::size_t promised, std::size_t there) const {
        if (promised > there)
            fail(ErrorCode::kInvalidInput,
                 "{}: the header promises {} {}, but lines are there for only {}: the file is cut "
                 "off, or the header is wrong",
                 source_.name, promised, what, there);
    }

    PointRows read_vertices(std::string_view part) const {
        TextLayout layout;
        layout.line_end = source_.line_end;
        layout.syntax = kSyntax;
        layout.begin = static_cast<std::size_t>(part.data() - source_.text.data());
        layout.end = layout.begin + part.size();
        for (Fields fields(without_comment(next_row(part))); !fields.at_end(); fields.word())
            ++layout.num_columns;
        if (layout.num_columns < 3)
            fail(ErrorCode::kInvalidInput, "{}: three coordinates are wanted", source_.place(part));
        layout.is_number.assign(layout.num_columns, true);
        layout.names = vertex_names(keyword_, layout.num_columns);
        return read_text_points(source_.text, layout, path_, {}, context_);
    }

    static std::string_view without_comment(std::string_view line) {
        return line.substr(0, line.find('#'));
    }

    std::string_view next_row(std::string_view rest) const {
        while (!rest.empty())
            if (const std::string_view line = take_line(rest, source_.line_end); is_text_row(line))
                return line;
        return rest;
    }

    /// Polygons become fans; those with a bad corner are counted.
    void add_faces(std::string_view rest, FinishedCloud& finished) const {
        Mesh mesh;
        std::uint64_t num_bad = 0;
        std::vector<Index> corners;
        for (std::size_t i = 0; i < num_faces_ && !rest.empty();) {
            const std::string_view line = take_line(rest, source_.line_end);
            if (!is_text_row(line)) continue;
            if (i++ % kLinesPerPoll == 0) check_cancelled(context_);
            const std::size_t num_before = mesh.triangles.size();
            if (read_corners(without_comment(line), finished.point_of_row, corners))
                for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
                    const Triangle t{corners[0], corners[k], corners[k + 1]};
                    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) mesh.triangles.push_back(t);
                }
            num_bad += mesh.triangles.size() == num_before;
        }
        finished.result.report.num_bad_faces = num_bad;
        if (mesh.triangles.empty()) return;
        mesh.positions = finished.result.cloud.positions;
        mesh.colors = finished.result.cloud.colors;
        finished.result.mesh = std::move(mesh);
    }

    static bool read_corners(std::string_view line, const std::vector<Index>& point_of_row,
                             std::vector<Index>& corners) {
        corners.clear();
        Fields fields(line);
        double count = 0.0;
        if (!fields.number(count) || !(count >= 3.0) || count != std::floor(count)) return false;
        for (double k = 0.0; k < count; ++k) {
            double value = 0.0;
            if (fields.at_end() || !fields.number(value)) return false;
            if (!(value >= 0.0 && value < static_cast<double>(point_of_row.size())) ||
                value != std::floor(value))
                return false;
            const Index point = point_of_row[static_cast<std::size_t>(value)];
            if (point == kInvalidIndex) return false;
            corners.push_back(point);
        }
        return true;
    }

    const std::filesystem::path& path_;
    TextSource source_;
    const Context& context_;
    Keyword keyword_;
    std::size_t num_vertices_ = 0, num_faces_ = 0;
    std::string_view body_;
};

}  // namespace

bool is_off(std::string_view text) {
    constexpr std::size_t kLookAt = 4096;
    const char line_end = line_end_of(text);
    std::string_view begin = text.substr(0, kLookAt);
    while (!begin.empty()) {
        const std::string_view line = take_line(begin, line_end);
        if (!line.empty() && line[0] != '#') return keyword_of(line).has_value();
    }
    return false;
}

LoadResult read_off(std::string_view text, const std::filesystem::path& path,
                    const Context& context) {
    LoadResult result = OffReader(text, path, context).read();
    report_progress(context, "load", 1.0);
    return result;
}

}  // namespace pointbake
