// The texts painted on the six faces of the box around a model.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pointbake/vec.h"

namespace pointbake {

enum class Ink : std::uint8_t { kNavy, kIvory, kRed };

/// The face of the box that a normal points to most: +x, -x, +y, -y, +z, -z.
enum class BoxFace : std::uint8_t { kRight, kLeft, kTop, kBottom, kFront, kBack };
BoxFace box_face(Vec3d normal);

/// Place on a face as seen from outside: u to the right, v up. Periodic in u with period 1.
Vec2d face_place(BoxFace face, Vec3d p);

struct LetterSample {
    double distance = 1.0;  ///< to the edge of the nearest stroke, negative within; 1 = far
    Ink ink = Ink::kNavy;
};

/// All texts, in a grid that finds the strokes near a place in constant time.
class Lettering {
 public:
    Lettering();
    LetterSample at(BoxFace face, Vec2d place) const;

 private:
    static constexpr int kCells = 96;
    struct Segment {
        Vec2d a, along;  // from a to a + along
        double inverse_length2 = 0.0, half_width = 0.0;
        Ink ink = Ink::kNavy;
    };
    struct Face {
        std::vector<Segment> segments;
        std::vector<std::uint32_t> begin, items;  // per cell: segments[items[begin[c]]] ...
    };
    static void sort_into_cells(Face& face);
    std::array<Face, 6> faces_;
};

}  // namespace pointbake
