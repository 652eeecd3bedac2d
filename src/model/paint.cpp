// The paint of the demo model. It is a function of place and normal alone, laid out for the demo
// model (model/demo_shape.h, in units of its longest side, from the corner of its box), but covers
// all space: any model in the unit box gets a ruler, a frieze of lettering, a checkered top, and
// above it flat blue with a gradient, fine lines, lettering and a bee.
#include <algorithm>
#include <cmath>

#include "model/brush.h"
#include "model/decals.h"
#include "model/demo_shape.h"
#include "model/lettering.h"
#include "pointbake/model.h"

namespace pointbake {
namespace {

using namespace palette;
using M = DemoMeasures;

constexpr double kSize = 2.0;  // longest side of the model
constexpr Vec3d relative(Vec3d p) {
    return {(p.x + 1.0) / kSize, p.y / kSize, (p.z + 0.7) / kSize};
}

constexpr double kBaseTop = 2.0 * M::half_base.y / kSize;
constexpr double kBlockTop = M::top / kSize;
constexpr double kChamferLow = (M::top - M::chamfer) / kSize;
constexpr double kGroundTop = kBlockTop + 0.002;  // the paint of what stands on the plinth begins

double radius_around(Vec3d axis, Vec3d p) {
    const double x = p.x - axis.x, z = p.z - axis.z;
    return std::sqrt(x * x + z * z);
}

// Angle of (x, y) in turns, [0, 1), to 1e-4. A polynomial: the same bits everywhere.
double turn(double x, double y) {
    const double ax = std::abs(x), ay = std::abs(y);
    if (ax + ay == 0.0) return 0.0;
    const double t = std::min(ax, ay) / std::max(ax, ay), s = t * t;
    constexpr double kQuarter = 1.57079632679489662;
    double angle = t + t * s * (-0.327622764 + s * (0.15931422 - 0.0464964749 * s));
    if (ay > ax) angle = kQuarter - angle;
    if (x < 0.0) angle = 2.0 * kQuarter - angle;
    if (y < 0.0) angle = 4.0 * kQuarter - angle;
    return angle / (4.0 * kQuarter);
}

// A square wave of period 2 with a soft edge of kEdgeRamp at each whole number; `unit` is the
// length of 1.
double wave(double x, double unit) {
    const double half = x * 0.5, phase = half - std::floor(half);  // [0, 1): first half up
    const double to_edge = std::min({phase, std::abs(phase - 0.5), 1.0 - phase}) * 2.0 * unit;
    const double level = std::min(1.0, to_edge / (0.5 * kEdgeRamp));
    return phase < 0.5 ? level : -level;
}
double checker(double x, double y, double unit) {
    return 0.5 + 0.5 * wave(x / unit, unit) * wave(y / unit, unit);
}

// Ochre with ticks in three widths; every tenth of the model's size gets a long one.
void paint_ruler(Vec2d place, Brush& brush) {
    struct Tick {
        double period, half_width, length;
    };
    constexpr Tick kTicks[] = {{0.01, 0.0006, 0.009}, {0.05, 0.0011, 0.014}, {0.1, 0.0016, 0.021}};
    brush.lay(kOchre, 1.0);
    for (const Tick& t : kTicks) {
        const double u = place.x / t.period;
        const double aside = std::abs(u - std::floor(u + 0.5)) * t.period;
        brush.fill(kNavy, std::max(aside - t.half_width, kBaseTop - t.length - place.y));
    }
}

// The plinth: ruler, block, chamfer, lawn. Faces blend where the normal turns.
void paint_plinth(Vec3d p, Vec3d n, BoxFace face, Vec2d place, Brush& brush) {
    brush.lay(kIvory, 1.0);
    brush.lay(kSea, ramp(std::abs(n.x) - std::abs(n.z), -0.05, 0.05));
    brush.fill(kTerracotta, kChamferLow - p.y);
    if (p.y < kBaseTop + kEdgeRamp) {  // with the ledge around the block
        Brush ruler{kOchre};
        if (face != BoxFace::kTop && face != BoxFace::kBottom) paint_ruler(place, ruler);
        brush.lay(ruler.color, coverage(p.y - kBaseTop - 0.5 * kEdgeRamp));
        brush.lay(kIvory, ramp(-n.y, 0.8, 0.9));
    } else if (p.y > kChamferLow) {
        Brush lawn{kGrass};
        constexpr double kTile = 0.05;
        lawn.lay(kMeadow, checker(p.x, p.z - 0.35, kTile));
        brush.lay(lawn.color, ramp(n.y, 0.80, 0.90));
    }
}

struct Mushroom {
    Vec3d foot;
    double size;
    Vec3d cap;
};
constexpr Mushroom kMushrooms[] = {
    {relative(M::mushroom), 0.62 / kSize, kRed},
    {relative(M::sprout), 0.30 / kSize, kOrange},
    {relative({M::pot.x, M::lid + 0.10, M::pot.z}), 0.20 / kSize, kRed},
};

bool is_on_mushroom(const Mushroom& m, Vec3d p) {
    const double h = (p.y - m.foot.y) / m.size;
    return h > -0.02 && h < 1.05 && radius_around(m.foot, p) < (h > 0.5 ? 0.49 : 0.24) * m.size;
}

void paint_mushroom(const Mushroom& m, Vec3d p, Vec3d n, Brush& brush) {
    const Vec3d q = (p - m.foot) / m.size;
    brush.lay(kBark, 1.0);
    brush.lay(kIvory, ramp(q.y, 0.0, 0.5));
    // Gills: fine rays under the cap.
    const double rim = 0.585;  // just above the cap's lower edge
    if (q.y > 0.5) {
        Brush gills{kIvory};
        constexpr double kNumGills = 48.0;
        const double angle = turn(q.x, q.z);
        const double r = std::sqrt(q.x * q.x + q.z * q.z) * m.size;
        const double aside = std::abs(angle * kNumGills - std::floor(angle * kNumGills + 0.5)) *
                             6.2832 * r / kNumGills;
        gills.fill(kBark, aside - 0.0009);
        brush.lay(gills.color, ramp(-n.y, 0.1, 0.3));
    }
    brush.fill(m.cap, (rim - q.y) * m.size);
    // White dots: where spheres around points of the cap cut it.
    struct Dot {
        double x, y, z, radius;
    };
    constexpr Dot kDots[] = {
        {0.03, 0.98, 0.02, 0.090},   {0.26, 0.88, 0.15, 0.075},   {-0.05, 0.86, 0.33, 0.080},
        {-0.30, 0.87, 0.05, 0.070},  {-0.08, 0.88, -0.30, 0.075}, {0.27, 0.86, -0.20, 0.065},
        {0.42, 0.73, 0.10, 0.060},   {0.25, 0.72, 0.37, 0.065},   {0.04, 0.69, 0.45, 0.045},
        {-0.22, 0.71, 0.38, 0.060},  {-0.42, 0.72, 0.14, 0.055},  {-0.40, 0.73, -0.18, 0.060},
        {-0.15, 0.70, -0.42, 0.055}, {0.17, 0.72, -0.40, 0.060},  {0.41, 0.70, -0.18, 0.050}};
    for (const Dot& d : kDots)
        brush.fill(kWhite, (length(q - Vec3d{d.x, d.y, d.z}) - d.radius) * m.size);
}

constexpr Vec3d kLeafCenter = relative(M::leaf);
constexpr double kLeafRadius = M::leaf_radius / kSize;

bool is_on_leaf(Vec3d p) {
    return p.y < kLeafCenter.y + 0.1 && radius_around(kLeafCenter, p) < kLeafRadius + 0.008;
}

// Veins from thick to fine.
void paint_leaf(Vec3d p, Vec3d n, Brush& brush) {
    const double x = p.x - kLeafCenter.x, z = p.z - kLeafCenter.z;
    brush.lay(kDeepLeaf, 1.0);
    Brush upper{kLeaf};
    const double slanted = (x - 0.8 * std::abs(z)) / 0.022;
    const double aside = std::abs(slanted - std::floor(slanted + 0.5)) * 0.022 / 1.28;
    upper.fill(kMeadow, std::max(aside - 0.0008, std::abs(z) - 0.105));
    const double fourth = slanted / 3.0;
    upper.fill(kMeadow, std::abs(fourth - std::floor(fourth + 0.5)) * 0.066 / 1.28 - 0.0018);
    upper.fill(kMeadow, std::abs(z) - 0.0034);
    upper.fill(kDeepLeaf, kLeafRadius - 0.008 - std::sqrt(x * x + z * z));
    brush.lay(upper.color, ramp(n.y, 0.35, 0.5) * ramp(p.y, 0.300, 0.302));
}

constexpr Vec3d kPot = relative(M::pot);

// Distance to the pot's body, roughly, in units of the longest side.
double off_body(Vec3d p) {
    const Vec3d q = p - kPot;
    const double rx = M::pot_radii.x / kSize, ry = M::pot_radii.y / kSize;
    return (std::sqrt((q.x * q.x + q.z * q.z) / (rx * rx) + q.y * q.y / (ry * ry)) - 1.0) * ry;
}

// A cord around the handle: stripes along its ring.
bool paint_handle(Vec3d p, double off, Brush& brush) {
    constexpr Vec3d kRing = relative({M::pot.x - 0.44, M::pot.y + 0.03, M::pot.z});
    const double x = p.x - kRing.x, y = p.y - kRing.y, z = p.z - kRing.z;
    const double ring = std::sqrt(x * x + y * y), around = ring - 0.235 / kSize;
    if (off < 0.014 || around * around + z * z > 0.026 * 0.026) return false;
    constexpr double kStripes = 36.0;
    brush.lay(kNavy, 1.0);
    brush.lay(kGold, 0.5 + 0.5 * wave(turn(x, y) * kStripes, 6.2832 * ring / kStripes));
    return true;
}

// Above the demo model, for models that are taller.
constexpr double kSkyline = 0.775;

// Everything above the plinth that is nothing else: blue below, pale above, bands by height.
void paint_pot(Vec3d p, double off, Brush& brush) {
    const double v = p.y;
    brush.lay(kSky, 1.0);
    brush.lay(kPale, ramp(v, 0.48, 0.552));
    brush.fill(kNavy, v - 0.302);
    struct Ring {
        double height, width;
    };
    constexpr Ring kRings[] = {
        {0.318, 0.0080}, {0.3285, 0.0042}, {0.3350, 0.0022}, {0.3390, 0.0012}};
    for (const Ring& r : kRings) brush.fill(kIvory, std::abs(v - r.height) - 0.5 * r.width);
    if (std::abs(off) < 0.03 || v > 0.6) {
        constexpr double kTile = 0.014, kNumTiles = 84.0;
        const double r = radius_around(kPot, p);
        const double angle = turn(p.x - kPot.x, p.z - kPot.z) * kNumTiles;
        const double squares =
            0.5 + 0.5 * wave(angle, 6.2832 * r / kNumTiles) * wave((v - 0.560) / kTile, kTile);
        Brush tiles{kNavy};
        tiles.lay(kWhite, squares);
        brush.fill(kNavy, std::abs(v - 0.5775) - 0.0215);
        brush.lay(tiles.color, coverage(std::abs(v - 0.5775) - 0.0175));
        brush.fill(kTerracotta, 0.6010 - v);
        brush.lay(kGold, ramp(v, 0.6325, 0.6325 + kEdgeRamp));
        // The lid fades to red towards its middle.
        if (v > 0.634) {
            brush.lay(kTerracotta, ramp(0.125 - r, 0.0, 0.10));
        }
    } else {
        brush.fill(kGold, 0.630 - v);  // the spout's lip
    }
    brush.fill(kSea, kSkyline - v);
}

void paint_above(Vec3d p, Vec3d n, Brush& brush) {
    for (const Mushroom& m : kMushrooms)
        if (is_on_mushroom(m, p)) return paint_mushroom(m, p, n, brush);
    if (is_on_leaf(p)) return paint_leaf(p, n, brush);
    const double off = off_body(p);
    if (paint_handle(p, off, brush)) return;
    paint_pot(p, off, brush);
    constexpr double kBeeSize = 0.150, kFlowerSize = 0.075;
    paint_bee(Vec2d{p.x - kPot.x - 0.02, p.y - 0.462}, kBeeSize, ramp(n.z, 0.45, 0.55), brush);
    paint_flower(Vec2d{kPot.x - p.x, p.y - 0.478}, kFlowerSize, ramp(-n.z, 0.45, 0.55), brush);
}

Vec3d color_of(Ink ink) {
    switch (ink) {
        case Ink::kNavy:
            return kNavy;
        case Ink::kIvory:
            return kIvory;
        case Ink::kRed:
            break;
    }
    return kRed;
}

}  // namespace

Rgb16 paint_at(Vec3d p, Vec3d n) {
    static const Lettering lettering;
    const BoxFace face = box_face(n);
    const Vec2d place = face_place(face, p);
    Brush brush{kIvory};
    if (p.y <= kGroundTop) {
        paint_plinth(p, n, face, place, brush);
    } else {
        paint_above(p, n, brush);
    }
    // Letters fade out where the surface turns over to another face of the box.
    double sizes[3] = {std::abs(n.x), std::abs(n.y), std::abs(n.z)};
    std::sort(sizes, sizes + 3);
    double facing = ramp(sizes[2] - sizes[1], 0.02, 0.10);
    if (face == BoxFace::kBottom && p.y > kBaseTop) facing = 0.0;
    const LetterSample letter = lettering.at(face, place);
    brush.lay(color_of(letter.ink), facing * coverage(letter.distance));
    return brush.rgb16();
}

}  // namespace pointbake
