// Stands in for delaunay.cpp in builds without CGAL (-DPOINTBAKE_CGAL=OFF).
#include "core/message.h"
#include "reconstruct/delaunay.h"

namespace pointbake {

bool has_delaunay() { return false; }

Delaunay delaunay(std::span<const Vec3d>, const Context&, std::span<const Index>) {
    fail(ErrorCode::kUnsupported,
         "this build has no Delaunay triangulation (POINTBAKE_CGAL=OFF): use --method implicit, or "
         "build with -DPOINTBAKE_CGAL=ON");
}

}  // namespace pointbake
