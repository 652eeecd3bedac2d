// Which way the pieces of an open surface face.
#pragma once

#include "pointbake/reconstruct.h"

namespace pointbake {

/// Turns pieces to face where most of their points were seen from (`cloud.sensors`), else where the
/// file's normals (`cloud.given_normals`) point, if at least four fifths of them agree; normals of
/// larger pieces that do not are listed in `result.unsure_normals`. Other pieces stay as they are.
/// The vertices are points.
void face_in_place(const PointCloud& cloud, ReconstructResult& result);

}  // namespace pointbake
