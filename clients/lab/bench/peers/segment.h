// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Another library's first hit of a segment on a mesh. None distinguishes front and back faces.
class SegmentPeer {
 public:
  virtual ~SegmentPeer() = default;
  /// Fraction of the segment, or negative for a miss.
  virtual double first_hit(const Vec3& from_O, const Vec3& to_O) = 0;
};

struct NamedPeer {
  std::string name;
  std::unique_ptr<SegmentPeer> peer;  // null: not installed at build time
};

/// Embree 3 robust first, then the CGAL AABB tree and Bullet; the mesh must outlive them.
std::vector<NamedPeer> make_segment_peers(const TriangleMesh& mesh);

}  // namespace haptic
