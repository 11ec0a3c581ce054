// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/query/triangle/closest_on_triangle.h"

namespace haptic {

/// An obstacle to the centre of a sphere: the plane of a face, the line of an edge, or a vertex.
struct RoundObstacle {
  FeatureKind kind = FeatureKind::kFace;
  Vec3 point_W;
  Vec3 direction_W;  // unit: normal of a face on the sphere's side, or along an edge
};

struct SphereRest {
  bool found = false;
  Vec3 centre_W;
};

/// Where a sphere that touches two or three obstacles comes to rest: the local minimum of |x −
/// tool| at `distance` from all of them, by Newton's method from from_W on x − tool = Σ λ_i
/// ∇d_i(x), d_i(x) = distance. Not found: it does not converge, an obstacle would have to pull (λ_i
/// < 0), or the place is no minimum along the crease. Sweeps along tangent planes converge to the
/// same place, but only in the limit.
SphereRest rest_in_crease(std::span<const RoundObstacle> obstacles, double distance,
                          const Vec3& from_W, const Vec3& tool_W);

}  // namespace haptic
