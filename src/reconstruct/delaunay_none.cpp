// Stands in for delaunay_cgal.cpp in builds without CGAL (-DPOINTBAKE_CGAL=OFF).
#include "core/message.h"
#include "reconstruct/delaunay.h"

namespace pointbake {

Delaunay delaunay(std::span<const Vec3d>, const Context&, std::span<const Index>) {
    fail(ErrorCode::kUnsupported,
         "this build has no Delaunay triangulation (POINTBAKE_CGAL=OFF): bring a mesh with --mesh, "
         "use --surface given, or build with -DPOINTBAKE_CGAL=ON");
}

}  // namespace pointbake
