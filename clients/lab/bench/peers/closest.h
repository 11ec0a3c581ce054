// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Another library's closest point: the distance from p_O to its mesh [m].
struct ClosestPeer {
  std::string name;
  std::function<double(const Vec3& p_O)> distance;
};

/// Embree 3 (float boxes, point–triangle distance in double in its callback): without warm start,
/// and with the distance to the previous closest point as radius. Empty if built without Embree.
std::vector<ClosestPeer> embree_peers(const TriangleMesh& mesh);

/// CGAL's AABB tree in double: with its own hints, and with the previous closest point as hint.
std::vector<ClosestPeer> cgal_peers(const TriangleMesh& mesh);

}  // namespace haptic
