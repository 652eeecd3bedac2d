// Processor time of the stage over that of CGAL's sequential Delaunay triangulation of the same
// points in the same run, the figure that reconstruct is held to:
//
//     reconstruct_ratio cocone|tight-cocone|robust-cocone|implicit|denoise [POINTS [NOISE
//     [THREADS [unthinned]]]]
//
// Noise in spacings; 0 for Cocone and Tight Cocone, else 0.3. Processor time, the better of two:
// other programs on the machine count little then. With more threads the seconds on the wall tell.
// One method a run, as the peak of memory is the process's.
// `off` is the mean distance from the mesh's vertices (denoise: the points) to the true torus, in
// spacings.
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <string>

#include "core/memory.h"
#include "plain_delaunay.h"
#include "pointbake/denoise.h"
#include "pointbake/reconstruct.h"
#include "support/shapes.h"

namespace pointbake {
namespace {

constexpr double kMinor = 0.4;
constexpr int kRuns = 2;

struct Seconds {
    double processor = HUGE_VAL, wall = HUGE_VAL;
};

double processor_seconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Keeps the better of what was and what body takes.
template <class Body>
void time_best(Seconds& best, Body&& body) {
    using Clock = std::chrono::steady_clock;
    const double before = processor_seconds();
    const auto start = Clock::now();
    body();
    const std::chrono::duration<double> wall = Clock::now() - start;
    best.processor = std::min(best.processor, processor_seconds() - before);
    best.wall = std::min(best.wall, wall.count());
}

/// How far a place lies outside a torus with waves, along the tube's radius. A torus without them
/// has a circle of points that all of a ring are as far from: more tetrahedra than real models.
double height(Vec3d p) {
    const double ring = std::hypot(p.x, p.z) - 1.0;
    const double wave = std::sin(5.0 * std::atan2(p.z, p.x) + 3.0 * std::atan2(p.y, ring));
    return std::hypot(ring, p.y) - kMinor - 0.05 * wave;
}

PointCloud wavy_torus(std::uint64_t n, double noise) {
    PointCloud cloud = shapes::torus_cloud(n, 1.0, kMinor);
    constexpr double kStep = 1e-6;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        Vec3d& p = cloud.positions[i];
        p -= vec_cast<double>(cloud.normals[i]) * height(p);
        const Vec3d normal = normalized(Vec3d{height(p + Vec3d{kStep, 0, 0}) - height(p),
                                              height(p + Vec3d{0, kStep, 0}) - height(p),
                                              height(p + Vec3d{0, 0, kStep}) - height(p)});
        cloud.normals[i] = vec_cast<float>(normal);
        p += normal * (noise * shapes::random_normal(1, i));
    }
    return cloud;
}

double mean_distance(const std::vector<Vec3d>& positions) {
    double sum = 0.0;
    for (const Vec3d p : positions) sum += std::abs(height(p));
    return sum / static_cast<double>(positions.size());
}

Method method_of(const std::string& word) {
    for (const Method m :
         {Method::kCocone, Method::kTightCocone, Method::kRobustCocone, Method::kImplicit})
        if (to_word(m) == word) return m;
    return Method::kAuto;
}

std::uint64_t resident_bytes() {
    std::uint64_t total = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> total >> resident;
    return resident * 4096;
}

int run(const std::string& word, std::uint64_t n, double noise, int threads, Thin thin) {
    const double spacing =
        std::sqrt(4.0 * std::numbers::pi * std::numbers::pi * kMinor / static_cast<double>(n));
    PointCloud cloud = wavy_torus(n, noise * spacing);
    cloud.areas.assign(cloud.size(), static_cast<float>(spacing * spacing));
    cloud.noise = noise;
    Context context;
    context.threads = threads;
    const std::uint64_t before = resident_bytes();
    Seconds stage, triangulation;
    double off = 0.0, bytes = 0.0;
    std::uint64_t triangles = 0, points = n;
    for (int i = 0; i < kRuns; ++i) {
        time_best(stage, [&] {
            if (word == "denoise") {
                const auto result = denoise(cloud, {.denoise = Denoise::kOn}, context);
                off = mean_distance(result.cloud.positions);
                return;
            }
            const auto result =
                reconstruct(cloud, {.method = method_of(word), .thin = thin}, context);
            off = mean_distance(result.surface.mesh.positions);
            triangles = result.report.num_triangles;
            points = n - result.report.num_thinned;
        });
        if (i == 0)
            bytes = static_cast<double>(peak_memory_bytes() - before) / static_cast<double>(points);
        time_best(triangulation, [&] { plain_delaunay(cloud.positions); });
    }
    std::printf(
        "%s, %llu points, noise %.2f, %d threads: %.2f s of processor, %.2f s; triangulation %.2f; "
        "ratio %.2f, wall %.2f; %.0f B per triangulated point; %llu triangles, %.4f off\n",
        word.c_str(), static_cast<unsigned long long>(n), noise, threads, stage.processor,
        stage.wall, triangulation.processor, stage.processor / triangulation.processor,
        stage.wall / triangulation.processor, bytes, static_cast<unsigned long long>(triangles),
        off / spacing);
    return 0;
}

}  // namespace
}  // namespace pointbake

int main(int argc, char** argv) {
    const std::string word = argc > 1 ? argv[1] : "tight-cocone";
    const std::uint64_t n = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1'000'000;
    const bool is_exact = word == "cocone" || word == "tight-cocone";
    const double noise = argc > 3 ? std::atof(argv[3]) : (is_exact ? 0.0 : 0.3);
    const pointbake::Thin thin = argc > 5 && std::string(argv[5]) == "unthinned"
                                     ? pointbake::Thin::kOff
                                     : pointbake::Thin::kAuto;
    return pointbake::run(word, n, noise, argc > 4 ? std::atoi(argv[4]) : 1, thin);
}
