// Glyphs are paths on a grid whose capitals are 12 high and whose small letters are 8 high:
//   M x y        go to        L x y    straight line to
//   C cx cy x y  quarter ellipse to (x, y) that leaves and arrives along the corner (cx, cy)
#include "model/stroke_font.h"

#include <array>
#include <cstddef>

namespace pointbake {
namespace {

constexpr double kCapHeight = 12.0;
constexpr double kGap = 3.1;    // between the strokes of neighbouring letters
constexpr double kSpace = 4.6;  // a blank's width
constexpr int kArcPieces = 5;   // lines per quarter ellipse: off by 0.6 % of its radius

struct Glyph {
    char letter;
    double width;
    std::string_view path;
};

constexpr Glyph kGlyphs[] = {
    {'A', 8.4, "M0 0L4.2 12L8.4 0M1.5 4.2L6.9 4.2"},
    {'B', 7.5, "M0 0L0 12L4 12C7 12 7 9.2C7 6.4 4 6.4L0 6.4M4 6.4C7.5 6.4 7.5 3.2C7.5 0 4 0L0 0"},
    {'C', 8.2, "M8 9.8C7.2 12 4.6 12C0 12 0 6C0 0 4.6 0C7.2 0 8.2 2.2"},
    {'D', 8.2, "M0 0L0 12L3.2 12C8.2 12 8.2 6C8.2 0 3.2 0L0 0"},
    {'E', 6.6, "M6.6 0L0 0L0 12L6.6 12M0 6.3L5.6 6.3"},
    {'F', 6.4, "M0 0L0 12L6.4 12M0 6.2L5.4 6.2"},
    {'G', 8.6, "M8.2 9.8C7.2 12 4.6 12C0 12 0 6C0 0 4.6 0C8.6 0 8.6 3.6L8.6 5.5L5.2 5.5"},
    {'H', 8.0, "M0 0L0 12M8 0L8 12M0 6.2L8 6.2"},
    {'I', 0.0, "M0 0L0 12"},
    {'J', 5.6, "M5.6 12L5.6 3.2C5.6 0 2.8 0C0 0 0 2.8"},
    {'K', 7.6, "M0 0L0 12M7.2 12L0 4.6M2.6 7.2L7.6 0"},
    {'L', 6.0, "M0 12L0 0L6 0"},
    {'M', 9.8, "M0 0L0 12L4.9 4L9.8 12L9.8 0"},
    {'N', 8.0, "M0 0L0 12L8 0L8 12"},
    {'O', 9.2, "M4.6 12C0 12 0 6C0 0 4.6 0C9.2 0 9.2 6C9.2 12 4.6 12"},
    {'P', 7.4, "M0 0L0 12L4 12C7.4 12 7.4 8.8C7.4 5.6 4 5.6L0 5.6"},
    {'Q', 9.2, "M4.6 12C0 12 0 6C0 0 4.6 0C9.2 0 9.2 6C9.2 12 4.6 12M5.6 3.2L9.2 -0.8"},
    {'R', 7.8, "M0 0L0 12L4 12C7.4 12 7.4 8.8C7.4 5.6 4 5.6L0 5.6M4 5.6L7.8 0"},
    {'S', 7.5,
     "M7 10C6.2 12 3.8 12C0.4 12 0.4 9.2C0.4 7 3.7 6.3C7.5 5.5 7.5 3C7.5 0 3.7 0"
     "C0.9 0 0 2.2"},
    {'T', 8.4, "M0 12L8.4 12M4.2 12L4.2 0"},
    {'U', 8.0, "M0 12L0 4.2C0 0 4 0C8 0 8 4.2L8 12"},
    {'V', 8.4, "M0 12L4.2 0L8.4 12"},
    {'W', 12.0, "M0 12L3 0L6 10.4L9 0L12 12"},
    {'X', 8.0, "M0 0L7.7 12M0.3 12L8 0"},
    {'Y', 8.2, "M0 12L4.1 5.8L8.2 12M4.1 5.8L4.1 0"},
    {'Z', 7.7, "M0.2 12L7.5 12L0 0L7.7 0"},
    {'a', 6.2,
     "M0.6 6.4C1.4 8 3.2 8C6.2 8 6.2 5.2L6.2 0M6.2 4.7L3.1 4.7C0 4.7 0 2.35C0 0 2.7 0"
     "C5.2 0 6.2 2.2"},
    {'b', 6.8, "M0 12L0 0M0 4C0 8 3.4 8C6.8 8 6.8 4C6.8 0 3.4 0C0 0 0 4"},
    {'c', 6.0, "M6 6.4C5.2 8 3.5 8C0 8 0 4C0 0 3.5 0C5.2 0 6 1.6"},
    {'d', 6.8, "M6.8 12L6.8 0M6.8 4C6.8 8 3.4 8C0 8 0 4C0 0 3.4 0C6.8 0 6.8 4"},
    {'e', 6.8, "M0 4.2L6.8 4.2C6.8 8 3.4 8C0 8 0 4C0 0 3.6 0C5.6 0 6.5 1.7"},
    {'f', 4.6, "M4.6 11.9C1.7 12.3 1.7 9.2L1.7 0M0 7.8L4.4 7.8"},
    {'g', 6.8,
     "M6.8 4C6.8 8 3.4 8C0 8 0 4C0 0 3.4 0C6.8 0 6.8 4M6.8 8L6.8 -0.8C6.8 -4 3.5 -4"
     "C1.6 -4 0.6 -2.9"},
    {'h', 6.3, "M0 12L0 0M0 4.4C0 8 3.4 8C6.3 8 6.3 4.8L6.3 0"},
    {'i', 0.0, "M0 8L0 0M0 11.3L0 11.3"},
    {'j', 2.2, "M2.2 8L2.2 -1.6C2.2 -4 0 -4M2.2 11.3L2.2 11.3"},
    {'k', 6.0, "M0 12L0 0M5.6 8L0 3M2.2 5L6 0"},
    {'l', 1.7, "M0 12L0 1.9C0 0 1.7 0"},
    {'m', 10.2,
     "M0 8L0 0M0 4.8C0 8 2.7 8C5.1 8 5.1 5L5.1 0M5.1 4.8C5.1 8 7.8 8C10.2 8 10.2 5"
     "L10.2 0"},
    {'n', 6.3, "M0 8L0 0M0 4.4C0 8 3.4 8C6.3 8 6.3 4.8L6.3 0"},
    {'o', 7.2, "M3.6 8C0 8 0 4C0 0 3.6 0C7.2 0 7.2 4C7.2 8 3.6 8"},
    {'p', 6.8, "M0 8L0 -4M0 4C0 8 3.4 8C6.8 8 6.8 4C6.8 0 3.4 0C0 0 0 4"},
    {'q', 6.8, "M6.8 8L6.8 -4M6.8 4C6.8 8 3.4 8C0 8 0 4C0 0 3.4 0C6.8 0 6.8 4"},
    {'r', 3.8, "M0 8L0 0M0 4.2C0 8 3.8 7.8"},
    {'s', 5.8,
     "M5.4 6.6C4.6 8 2.9 8C0.4 8 0.4 6C0.4 4.5 2.9 4.1C5.8 3.6 5.8 2.1C5.8 0 2.8 0"
     "C0.8 0 0 1.6"},
    {'t', 4.4, "M1.8 11L1.8 2.4C1.8 -0.2 4.4 0.15M0 7.8L4.4 7.8"},
    {'u', 6.3, "M0 8L0 3.2C0 0 3 0C6.3 0 6.3 3.6M6.3 8L6.3 0"},
    {'v', 6.2, "M0 8L3.1 0L6.2 8"},
    {'w', 9.2, "M0 8L2.4 0L4.6 7L6.8 0L9.2 8"},
    {'x', 6.0, "M0 0L5.8 8M0.2 8L6 0"},
    {'y', 6.2, "M0 8L3.2 0.2M6.2 8L1.7 -4"},
    {'z', 5.8, "M0.2 8L5.6 8L0 0L5.8 0"},
    {'0', 7.0, "M3.5 12C0 12 0 6C0 0 3.5 0C7 0 7 6C7 12 3.5 12"},
    {'1', 3.2, "M0 9.6L3.2 12L3.2 0"},
    {'2', 7.0, "M0.2 9C0.4 12 3.5 12C6.8 12 6.8 8.9C6.8 6.8 4.6 4.6L0 0L7 0"},
    {'3', 7.0,
     "M0.3 10.2C1.2 12 3.4 12C6.6 12 6.6 9.25C6.6 6.5 3.4 6.5L2.4 6.5M3.4 6.5"
     "C7 6.5 7 3.25C7 0 3.4 0C0.9 0 0 2"},
    {'4', 7.6, "M5.6 0L5.6 12L0 3.6L7.6 3.6"},
    {'5', 7.0, "M6.4 12L1 12L0.6 6.4C1.7 7.6 3.5 7.6C7 7.6 7 3.8C7 0 3.3 0C0.9 0 0 1.8"},
    {'6', 7.0,
     "M6.3 10.4C5.4 12 3.8 12C0 12 0 5L0 3.8C0 0 3.5 0C7 0 7 3.8C7 7.6 3.5 7.6"
     "C0 7.6 0 3.8"},
    {'7', 7.0, "M0 12L7 12L2.6 0"},
    {'8', 7.0,
     "M3.5 12C0.4 12 0.4 9.2C0.4 6.4 3.5 6.4C6.6 6.4 6.6 9.2C6.6 12 3.5 12M3.5 6.4"
     "C0 6.4 0 3.2C0 0 3.5 0C7 0 7 3.2C7 6.4 3.5 6.4"},
    {'9', 7.0,
     "M0.7 1.6C1.6 0 3.2 0C7 0 7 7L7 8.2C7 12 3.5 12C0 12 0 8.2C0 4.4 3.5 4.4"
     "C7 4.4 7 8.2"},
    {'.', 0.0, "M0 0.2L0 0.2"},
    {',', 0.8, "M0.8 0.4L0 -2.2"},
    {':', 0.0, "M0 0.2L0 0.2M0 7.2L0 7.2"},
    {';', 0.8, "M0.8 0.4L0 -2.2M0.6 7.2L0.6 7.2"},
    {'!', 0.0, "M0 12L0 4M0 0.2L0 0.2"},
    {'?', 6.2,
     "M0 9.4C0.2 12 3.1 12C6.2 12 6.2 9.2C6.2 7.2 4.4 6.2C3.1 5.4 3.1 3.6M3.1 0.2L3.1 0.2"},
    {'-', 4.0, "M0 4.6L4 4.6"},
    {'+', 6.4, "M0 5.2L6.4 5.2M3.2 2L3.2 8.4"},
    {'=', 6.4, "M0 3.8L6.4 3.8M0 6.8L6.4 6.8"},
    {'/', 5.2, "M0 -1.5L5.2 13"},
    {'\'', 0.0, "M0 12L0 9.4"},
    {'"', 2.6, "M0 12L0 9.4M2.6 12L2.6 9.4"},
    {'(', 2.4, "M2.4 13.2C0 10.6 0 5.6C0 0.6 2.4 -2"},
    {')', 2.4, "M0 13.2C2.4 10.6 2.4 5.6C2.4 0.6 0 -2"},
    {'%', 9.4,
     "M1.2 0L8.2 12M2 12C0 12 0 9.6C0 7.2 2 7.2C4 7.2 4 9.6C4 12 2 12M7.4 4.8"
     "C5.4 4.8 5.4 2.4C5.4 0 7.4 0C9.4 0 9.4 2.4C9.4 4.8 7.4 4.8"},
    {'&', 8.6,
     "M8.6 0L2.1 7.8C0.2 12 3.8 12C6.8 12 6 8.8C5.4 7 2.2 5.8C0 4.8 0 2.8C0 0 3.6 0"
     "C6.8 0 8.2 4.8"},
};

const Glyph* find_glyph(char letter) {
    for (const Glyph& g : kGlyphs)
        if (g.letter == letter) return &g;
    return nullptr;
}

// Takes the next number (digits, point, sign) off the front of a path.
double take_number(std::string_view& path) {
    while (!path.empty() && path.front() == ' ') path.remove_prefix(1);
    double sign = 1.0, value = 0.0, unit = 0.0;
    for (; !path.empty(); path.remove_prefix(1)) {
        const char c = path.front();
        if (c == '-' && value == 0.0) {
            sign = -1.0;
        } else if (c == '.') {
            unit = 1.0;
        } else if (c >= '0' && c <= '9') {
            value = value * 10.0 + (c - '0');
            unit *= 10.0;
        } else {
            break;
        }
    }
    return sign * (unit > 0.0 ? value / unit : value);
}

Vec2d take_point(std::string_view& path) {
    const double x = take_number(path);
    return {x, take_number(path)};
}

// A rational quadratic whose middle weight sqrt(1/2) makes it a quarter of an ellipse.
void add_arc(Vec2d a, Vec2d corner, Vec2d b, std::vector<Stroke>& strokes) {
    const double weight = std::sqrt(0.5);
    Vec2d from = a;
    for (int k = 1; k <= kArcPieces; ++k) {
        const double t = static_cast<double>(k) / kArcPieces, s = 1.0 - t;
        const double wa = s * s, wc = 2.0 * s * t * weight, wb = t * t;
        const Vec2d to = (a * wa + corner * wc + b * wb) / (wa + wc + wb);
        strokes.push_back({from, to});
        from = to;
    }
}

void add_glyph(std::string_view path, double x, std::vector<Stroke>& strokes) {
    const std::size_t first = strokes.size();
    Vec2d at;
    while (!path.empty()) {
        const char command = path.front();
        path.remove_prefix(1);
        if (command == 'C') {
            const Vec2d corner = take_point(path), to = take_point(path);
            add_arc(at, corner, to, strokes);
            at = to;
        } else {
            const Vec2d to = take_point(path);
            if (command == 'L') strokes.push_back({at, to});
            at = to;
        }
    }
    const auto placed = [&](Vec2d p) { return Vec2d{p.x + x, p.y} / kCapHeight; };
    for (std::size_t k = first; k < strokes.size(); ++k)
        strokes[k] = {placed(strokes[k].a), placed(strokes[k].b)};
}

}  // namespace

TextStrokes text_strokes(std::string_view text) {
    TextStrokes result;
    double x = 0.0;
    for (const char letter : text) {
        const Glyph* glyph = find_glyph(letter);
        if (glyph == nullptr) {
            x += kSpace;
            continue;
        }
        add_glyph(glyph->path, x, result.strokes);
        result.width = (x + glyph->width) / kCapHeight;
        x += glyph->width + kGap;
    }
    return result;
}

}  // namespace pointbake
