// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Another's closest point: the distance from p_O to the mesh it was made for [m].
struct ClosestPeer {
  std::string name;
  std::function<double(const Vec3& p_O)> distance;
};

/// Embree 3 (float boxes, point–triangle in double in its callback): cold, and with the distance to
/// the previous closest point as radius. Nothing where it was not there when this was built.
std::vector<ClosestPeer> embree_peers(const TriangleMesh& mesh);

/// CGAL's AABB tree in double: with its own hints, and with the previous closest point as hint.
std::vector<ClosestPeer> cgal_peers(const TriangleMesh& mesh);

}  // namespace haptic
