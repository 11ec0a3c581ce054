// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Another library's first hit of a segment on a mesh. None distinguishes front and back faces.
struct SegmentPeer {
  std::string name;
  /// Fraction of the segment, or negative for a miss; empty if the library was not installed.
  std::function<double(const Vec3& from_O, const Vec3& to_O)> first_hit = {};
};

/// Embree 3 robust first, then the CGAL AABB tree and Bullet; the mesh must outlive them.
std::vector<SegmentPeer> make_segment_peers(const TriangleMesh& mesh);

}  // namespace haptic
