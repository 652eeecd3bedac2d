// [Wicke05] leaves the interpolated-normal projection open. p lies in the offset triangle with
// corners v_i + t n_i, so det[v_1 + t n_1 - p, v_2 + t n_2 - p, v_3 + t n_3 - p] = 0: a cubic in t,
// solved by Newton's method from the depth above the triangle's plane.
#include "texture/shell.h"

#include <algorithm>
#include <cmath>

#include "core/adjacency.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 1024;
constexpr double kMinNormalDot =
    0.15;  // a vertex normal this close to a face's plane makes the prism too thin
constexpr int kMaxTurns = 48;  // turns of a vertex normal towards faces it misses
constexpr int kMaxNewtonSteps = 12;
constexpr double kMaxDepthOverSize =
    1.0;  // roots farther than this many longest edges are another sheet's

Vec3d face_cross(const Mesh& mesh, Index t) {
    const auto& [a, b, c] = mesh.triangles[t];
    return cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
}

// [Max99]: weights sin(angle) / (|e1| |e2|) = |e1 x e2| / (|e1|^2 |e2|^2) are exact on a sphere.
Vec3d max_weighted_normal(const Mesh& mesh, Index v, std::span<const Index> triangles) {
    Vec3d sum{};
    for (Index t : triangles) {
        const Triangle& tri = mesh.triangles[t];
        const std::size_t k = tri[0] == v ? 0 : (tri[1] == v ? 1 : 2);
        const Vec3d e1 = mesh.positions[tri[(k + 1) % 3]] - mesh.positions[v];
        const Vec3d e2 = mesh.positions[tri[(k + 2) % 3]] - mesh.positions[v];
        const double weight = squared_length(e1) * squared_length(e2);
        if (weight > 0.0) sum += cross(e1, e2) / weight;
    }
    return normalized(sum);
}

double lowest_dot(Vec3d n, const std::vector<Vec3d>& faces, Vec3d& worst) {
    double lowest = HUGE_VAL;
    for (const Vec3d& f : faces) {
        const double d = dot(n, f);
        if (d < lowest) lowest = d, worst = f;
    }
    return lowest;
}

// Turns n towards the face it misses most, by ever smaller steps; the best direction seen counts,
// as no direction may see all faces well (a thin spike).
Vec3d turn_towards_faces(Vec3d n, const std::vector<Vec3d>& faces) {
    Vec3d best = n, worst{};
    double best_dot = lowest_dot(n, faces, worst);
    for (int turn = 0; turn < kMaxTurns && best_dot < kMinNormalDot; ++turn) {
        const double lowest = lowest_dot(n, faces, worst);
        if (lowest > best_dot) best = n, best_dot = lowest;
        n = normalized(n + worst * ((kMinNormalDot + 0.1 - lowest) / (1.0 + turn)));
    }
    return best;
}

struct Cubic {
    double c0, c1, c2, c3;
    double at(double t) const { return c0 + t * (c1 + t * (c2 + t * c3)); }
    double slope(double t) const { return c1 + t * (2.0 * c2 + t * 3.0 * c3); }
};

// det[u_0 + t n_0, u_1 + t n_1, u_2 + t n_2] expanded in t.
Cubic offset_determinant(const std::array<Vec3d, 3>& u, const std::array<Vec3d, 3>& n) {
    const auto det = [](Vec3d a, Vec3d b, Vec3d c) { return dot(a, cross(b, c)); };
    return {det(u[0], u[1], u[2]),
            det(n[0], u[1], u[2]) + det(u[0], n[1], u[2]) + det(u[0], u[1], n[2]),
            det(u[0], n[1], n[2]) + det(n[0], u[1], n[2]) + det(n[0], n[1], u[2]),
            det(n[0], n[1], n[2])};
}

// Root of the cubic near `start`; false if Newton's method does not settle within +-limit.
bool newton_root(const Cubic& f, double start, double limit, double& root) {
    double t = start;
    for (int step = 0; step < kMaxNewtonSteps; ++step) {
        const double slope = f.slope(t);
        if (slope == 0.0) return false;
        const double move = f.at(t) / slope;
        t -= move;
        if (!(std::fabs(t) <= limit)) return false;
        if (std::fabs(move) <= 1e-14 * limit) break;
    }
    root = t;
    return true;
}

}  // namespace

std::vector<Vec3f> shell_normals(const Mesh& mesh, const Context& context) {
    const VertexTriangles around = vertex_triangles(mesh.positions.size(), mesh.triangles);
    std::vector<Vec3f> normals(mesh.positions.size());
    parallel_for(context, normals.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<Vec3d> faces;
        for (std::size_t i = begin; i < end; ++i) {
            const auto v = static_cast<Index>(i);
            faces.clear();
            for (Index t : around.of(v)) faces.push_back(normalized(face_cross(mesh, t)));
            const Vec3d n = max_weighted_normal(mesh, v, around.of(v));
            normals[i] = vec_cast<float>(turn_towards_faces(n, faces));
        }
    });
    return normals;
}

TriangleFrame triangle_frame(const Mesh& mesh, Index triangle) {
    const Triangle& tri = mesh.triangles[triangle];
    TriangleFrame frame;
    double longest = -1.0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double l = squared_length(mesh.positions[tri[(k + 1) % 3]] - mesh.positions[tri[k]]);
        if (l > longest) longest = l, frame.left = static_cast<int>(k);
    }
    const auto left = static_cast<std::size_t>(frame.left);
    const Vec3d apex = mesh.positions[tri[(left + 2) % 3]];
    frame.origin = mesh.positions[tri[left]];
    frame.ex = normalized(mesh.positions[tri[(left + 1) % 3]] - frame.origin);
    frame.ez = normalized(cross(frame.ex, apex - frame.origin));
    frame.ey = cross(frame.ez, frame.ex);
    frame.corners[left] = {0.0, 0.0};
    frame.corners[(left + 1) % 3] = {std::sqrt(longest), 0.0};
    frame.corners[(left + 2) % 3] = {dot(frame.ex, apex - frame.origin),
                                     dot(frame.ey, apex - frame.origin)};
    return frame;
}

Shell::Shell(const Mesh& mesh, Projection projection, const Context& context)
    : mesh_(mesh), projection_(projection), normals_(shell_normals(mesh, context)) {
    frames_.resize(mesh.triangles.size());
    parallel_for(context, frames_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            frames_[t] = triangle_frame(mesh_, static_cast<Index>(t));
        }
    });
}

ShellPoint Shell::project_orthographic(Index triangle, Vec3d p) const {
    const TriangleFrame& frame = frames_[triangle];
    const Vec3d d = p - frame.origin;
    const Vec2d x{dot(frame.ex, d), dot(frame.ey, d)};
    const auto& c = frame.corners;
    const double area = cross(c[1] - c[0], c[2] - c[0]);
    ShellPoint out;
    if (area > 0.0) {
        out.barycentric = {cross(c[1] - x, c[2] - x) / area, cross(c[2] - x, c[0] - x) / area, 0.0};
        out.barycentric.z = 1.0 - out.barycentric.x - out.barycentric.y;
    } else {
        out.barycentric = {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0};
    }
    out.depth = dot(frame.ez, d);
    out.direction = frame.ez;
    out.gradient = {frame.ex, frame.ey};
    return out;
}

ShellPoint Shell::project(Index triangle, Vec3d p) const {
    ShellPoint flat = project_orthographic(triangle, p);
    if (projection_ == Projection::kOrthographic) return flat;

    const TriangleFrame& frame = frames_[triangle];
    const Triangle& tri = mesh_.triangles[triangle];
    std::array<Vec3d, 3> u, n;
    for (std::size_t k = 0; k < 3; ++k) {
        u[k] = mesh_.positions[tri[k]] - p;
        n[k] = vec_cast<double>(normals_[tri[k]]);
    }
    double t = 0.0;
    const double limit = kMaxDepthOverSize * frame.base() + std::fabs(flat.depth);
    if (!newton_root(offset_determinant(u, n), flat.depth, limit, t)) return flat;

    // Barycentrics in the offset triangle, by areas along its normal.
    const Vec3d a = u[0] + n[0] * t, b = u[1] + n[1] * t, c = u[2] + n[2] * t;
    const Vec3d normal = cross(b - a, c - a);
    const double area = squared_length(normal);
    if (!(area > 0.0) || !(dot(normal, frame.ez) > 0.0)) return flat;
    ShellPoint out;
    out.barycentric = {dot(cross(b, c), normal) / area, dot(cross(c, a), normal) / area, 0.0};
    out.barycentric.z = 1.0 - out.barycentric.x - out.barycentric.y;
    const Vec3d along =
        n[0] * out.barycentric.x + n[1] * out.barycentric.y + n[2] * out.barycentric.z;
    out.depth = t;
    out.direction = normalized(along);

    // dp = M (db_1, db_2, dt), M = [a - c, b - c, along]; rows of M^-1 are the gradients of b_1 and
    // b_2.
    const Vec3d m0 = a - c, m1 = b - c;
    const double det = dot(m0, cross(m1, along));
    if (!(det > 0.0)) return flat;
    const Vec3d g0 = cross(m1, along) / det, g1 = cross(along, m0) / det;
    const Vec2d p0 = frame.corners[0] - frame.corners[2], p1 = frame.corners[1] - frame.corners[2];
    out.gradient = {g0 * p0.x + g1 * p1.x, g0 * p0.y + g1 * p1.y};
    return out;
}

Vec3d Shell::normal_at(Index triangle, Vec2d x) const {
    const TriangleFrame& frame = frames_[triangle];
    if (!(frame.area() > 0.0)) return frame.ez;
    std::array<double, 3> b = frame.barycentric(x);
    double sum = 0.0;
    for (double& w : b) w = std::max(w, 0.0), sum += w;
    Vec3d n{};
    for (std::size_t k = 0; k < 3; ++k)
        n += vec_cast<double>(normals_[mesh_.triangles[triangle][k]]) * (b[k] / sum);
    return n;
}

}  // namespace pointbake
