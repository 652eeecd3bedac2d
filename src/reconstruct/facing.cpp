#include "reconstruct/facing.h"

#include <algorithm>

#include "core/adjacency.h"
#include "reconstruct/pieces.h"

namespace pointbake {
namespace {

// Directions nearer to the surface than this cosine tell no side.
constexpr double kLeastCos = 0.1;
// Normals of a piece of more than so many points count if this share of them is on one side.
constexpr double kAgreeing = 0.8;
constexpr std::size_t kFewPoints = 100;
// Sensors are asked where at least this share of a piece's points was seen from a side.
constexpr double kSeen = 0.1;

struct Votes {
    std::size_t front = 0, back = 0;
    std::size_t sum() const { return front + back; }
    void add(Vec3d normal, Vec3f direction) {
        const Vec3d d = vec_cast<double>(direction);
        const double cosine =
            dot(normal, d) / std::sqrt(squared_length(normal) * squared_length(d));
        front += cosine > kLeastCos ? 1 : 0;
        back += cosine < -kLeastCos ? 1 : 0;
    }
};

class Judge {
 public:
    Judge(const PointCloud& cloud, const DenseMesh& surface)
        : cloud_(cloud),
          points_(surface.vertex_points),
          has_sensors_(cloud.sensors.size() == cloud.size()),
          has_normals_(cloud.given_normals.size() == cloud.size() &&
                       cloud.normals.size() == cloud.size()),
          sums_(surface.mesh.positions.size()) {
        const auto& p = surface.mesh.positions;
        for (const Triangle& t : surface.mesh.triangles) {
            const Vec3d n = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
            for (Index v : t) sums_[v] += n;
        }
    }

    bool has_say() const { return has_sensors_ || has_normals_; }

    // Whether the piece over these vertices faces the wrong way.
    bool is_turned(std::span<const Index> vertices, std::vector<Index>& unsure) const {
        Votes seen, told;
        for (Index v : vertices) {
            if (has_sensors_) seen.add(sums_[v], cloud_.sensors[points_[v]]);
            if (is_told(v)) told.add(sums_[v], cloud_.normals[points_[v]]);
        }
        const auto most = static_cast<double>(std::max(told.front, told.back));
        const bool agree = most >= kAgreeing * static_cast<double>(told.sum());
        if (!agree && told.sum() > kFewPoints)
            for (Index v : vertices)
                if (is_told(v)) unsure.push_back(points_[v]);
        if (static_cast<double>(seen.sum()) >= kSeen * static_cast<double>(vertices.size()))
            return seen.back > seen.front;
        return agree && told.back > told.front;
    }

 private:
    bool is_told(Index v) const { return has_normals_ && cloud_.given_normals[points_[v]] != 0; }

    const PointCloud& cloud_;
    std::span<const Index> points_;
    bool has_sensors_, has_normals_;
    std::vector<Vec3d> sums_;  // of the triangles' normals around each vertex
};

}  // namespace

void face_in_place(const PointCloud& cloud, ReconstructResult& result) {
    const Judge judge(cloud, result.surface);
    if (!judge.has_say()) return;
    auto& triangles = result.surface.mesh.triangles;
    const Pieces pieces = find_pieces(triangle_neighbors(triangles));
    std::vector<Index> vertices;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        vertices.clear();
        for (Index t : pieces.of(p))
            vertices.insert(vertices.end(), triangles[t].begin(), triangles[t].end());
        std::sort(vertices.begin(), vertices.end());
        vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
        if (!judge.is_turned(vertices, result.unsure_normals)) continue;
        for (Index t : pieces.of(p)) std::swap(triangles[t][1], triangles[t][2]);
        ++result.report.num_turned_pieces;
    }
    std::sort(triangles.begin(), triangles.end());
    auto& unsure = result.unsure_normals;
    std::sort(unsure.begin(), unsure.end());
    unsure.erase(std::unique(unsure.begin(), unsure.end()), unsure.end());
}

}  // namespace pointbake
