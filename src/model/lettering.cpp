// Sentences of dictionary words, so that a reader (or a program that reads) can tell whether they
// survived; two of them use every letter. Sizes go down by about 1.6 from line to line.
#include "model/lettering.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "model/stroke_font.h"

namespace pointbake {
namespace {

// Strokes are looked for this far from their edge: more than the ramp of the paint.
constexpr double kReach = 0.002;

struct Line {
    BoxFace face;
    Vec2d middle;   // of the baseline
    double size;    // height of capitals
    double weight;  // stroke width / size
    Ink ink;
    std::string_view text;
};

// The plinth's block fills v in [0.05, 0.25]; its ruler lies below, the pot above.
constexpr Line kLines[] = {
    {BoxFace::kFront, {0.5, 0.162}, 0.080, 0.20, Ink::kNavy, "POINTBAKE"},
    {BoxFace::kFront, {0.5, 0.115}, 0.033, 0.17, Ink::kRed, "keeps every detail"},
    {BoxFace::kFront,
     {0.5, 0.0785},
     0.0185,
     0.155,
     Ink::kNavy,
     "The quick brown fox jumps over the lazy dog."},
    {BoxFace::kFront,
     {0.5, 0.0600},
     0.0115,
     0.15,
     Ink::kNavy,
     "From a cloud of points to a light mesh with a sharp texture, ready to use."},
    {BoxFace::kRight, {0.35, 0.175}, 0.054, 0.18, Ink::kIvory, "points in,"},
    {BoxFace::kRight, {0.35, 0.112}, 0.040, 0.17, Ink::kIvory, "triangles out"},
    {BoxFace::kRight,
     {0.35, 0.0700},
     0.0195,
     0.155,
     Ink::kIvory,
     "Sphinx of black quartz, judge my vow."},
    {BoxFace::kBack, {0.5, 0.200}, 0.034, 0.17, Ink::kNavy, "ABCDEFGHIJKLMNOPQRSTUVWXYZ"},
    {BoxFace::kBack, {0.5, 0.148}, 0.034, 0.17, Ink::kNavy, "abcdefghijklmnopqrstuvwxyz"},
    {BoxFace::kBack, {0.5, 0.098}, 0.030, 0.17, Ink::kRed, "0123456789 (+-=/%&?!.,:;)"},
    {BoxFace::kBack,
     {0.5, 0.0670},
     0.0185,
     0.155,
     Ink::kNavy,
     "Pack my box with five dozen liquor jugs."},
    {BoxFace::kLeft, {0.35, 0.190}, 0.038, 0.17, Ink::kIvory, "thin handles,"},
    {BoxFace::kLeft, {0.35, 0.132}, 0.038, 0.17, Ink::kIvory, "sharp edges"},
    {BoxFace::kLeft, {0.35, 0.090}, 0.024, 0.16, Ink::kIvory, "and a saddle to ride on"},
    {BoxFace::kLeft,
     {0.35, 0.0630},
     0.0150,
     0.15,
     Ink::kIvory,
     "How quickly daft jumping zebras vex!"},
    {BoxFace::kBottom, {0.5, 0.36}, 0.055, 0.17, Ink::kNavy, "made of nothing"},
    {BoxFace::kBottom, {0.5, 0.27}, 0.055, 0.17, Ink::kNavy, "but points"},
    {BoxFace::kFront, {0.43, 0.372}, 0.0260, 0.17, Ink::kNavy, "busy as a bee"},
    {BoxFace::kBack, {0.58, 0.372}, 0.0260, 0.17, Ink::kNavy, "time for tea"},
    // Above the demo model, for others that are taller.
    {BoxFace::kFront, {0.5, 0.84}, 0.055, 0.18, Ink::kIvory, "any surface"},
    {BoxFace::kFront, {0.5, 0.79}, 0.026, 0.16, Ink::kIvory, "carries its words"},
    {BoxFace::kBack, {0.5, 0.83}, 0.045, 0.17, Ink::kIvory, "round and round"},
    {BoxFace::kRight, {0.35, 0.83}, 0.045, 0.17, Ink::kIvory, "every side"},
    {BoxFace::kLeft, {0.35, 0.83}, 0.045, 0.17, Ink::kIvory, "left alone"},
};

// Digits under the ruler's long ticks, on the four sides.
constexpr BoxFace kSides[] = {BoxFace::kFront, BoxFace::kBack, BoxFace::kRight, BoxFace::kLeft};
constexpr std::string_view kDigits = "123456789";
constexpr double kDigitSize = 0.0150, kDigitBaseline = 0.0065;

int cell_of(double place, int cells) {
    return std::clamp(static_cast<int>(std::floor(place * cells)), 0, cells - 1);
}

}  // namespace

BoxFace box_face(Vec3d n) {
    const Vec3d size{std::abs(n.x), std::abs(n.y), std::abs(n.z)};
    if (size.z >= size.x && size.z >= size.y) return n.z >= 0.0 ? BoxFace::kFront : BoxFace::kBack;
    if (size.x >= size.y) return n.x >= 0.0 ? BoxFace::kRight : BoxFace::kLeft;
    return n.y >= 0.0 ? BoxFace::kTop : BoxFace::kBottom;
}

Vec2d face_place(BoxFace face, Vec3d p) {
    // The demo model is 0.7 deep: its sides begin at u = 0 whichever way they look.
    constexpr double kDepth = 0.7;
    switch (face) {
        case BoxFace::kRight:
            return {kDepth - p.z, p.y};
        case BoxFace::kLeft:
            return {p.z, p.y};
        case BoxFace::kTop:
            return {p.x, kDepth - p.z};
        case BoxFace::kBottom:
            return {p.x, p.z};
        case BoxFace::kFront:
            return {p.x, p.y};
        case BoxFace::kBack:
            break;
    }
    return {1.0 - p.x, p.y};
}

Lettering::Lettering() {
    const auto add = [&](const Line& line) {
        const TextStrokes text = text_strokes(line.text);
        const Vec2d left = line.middle - Vec2d{0.5 * text.width * line.size, 0.0};
        for (const Stroke& s : text.strokes) {
            const Vec2d a = left + s.a * line.size, along = (s.b - s.a) * line.size;
            const double length2 = dot(along, along);
            faces_[static_cast<std::size_t>(line.face)].segments.push_back(
                {a, along, length2 > 0.0 ? 1.0 / length2 : 0.0, 0.5 * line.weight * line.size,
                 line.ink});
        }
    };
    for (const Line& line : kLines) add(line);
    for (const BoxFace side : kSides)
        for (std::size_t k = 0; k < kDigits.size(); ++k)
            add({side,
                 {0.1 * static_cast<double>(k + 1), kDigitBaseline},
                 kDigitSize,
                 0.15,
                 Ink::kNavy,
                 kDigits.substr(k, 1)});
    for (Face& face : faces_) sort_into_cells(face);
}

void Lettering::sort_into_cells(Face& face) {
    std::vector<std::vector<std::uint32_t>> cells(kCells * kCells);
    for (std::uint32_t k = 0; k < face.segments.size(); ++k) {
        const Segment& s = face.segments[k];
        const Vec2d b = s.a + s.along;
        const double reach = s.half_width + kReach;
        const int right = cell_of(std::max(s.a.x, b.x) + reach, kCells);
        const int top = cell_of(std::max(s.a.y, b.y) + reach, kCells);
        for (int y = cell_of(std::min(s.a.y, b.y) - reach, kCells); y <= top; ++y)
            for (int x = cell_of(std::min(s.a.x, b.x) - reach, kCells); x <= right; ++x)
                cells[static_cast<std::size_t>(y * kCells + x)].push_back(k);
    }
    face.begin.assign(1, 0);
    for (const auto& cell : cells) {
        face.items.insert(face.items.end(), cell.begin(), cell.end());
        face.begin.push_back(static_cast<std::uint32_t>(face.items.size()));
    }
}

LetterSample Lettering::at(BoxFace side, Vec2d place) const {
    LetterSample nearest;
    if (!(place.y >= 0.0 && place.y < 1.0)) return nearest;
    place.x -= std::floor(place.x);
    const Face& face = faces_[static_cast<std::size_t>(side)];
    const auto cell =
        static_cast<std::size_t>(cell_of(place.y, kCells) * kCells + cell_of(place.x, kCells));
    for (std::uint32_t k = face.begin[cell]; k < face.begin[cell + 1]; ++k) {
        const Segment& s = face.segments[face.items[k]];
        const Vec2d q = place - s.a;
        const double t = std::clamp(dot(q, s.along) * s.inverse_length2, 0.0, 1.0);
        const double distance = length(q - s.along * t) - s.half_width;
        if (distance < nearest.distance) nearest = {distance, s.ink};
    }
    return nearest;
}

}  // namespace pointbake
