// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/detect/point/point_scene.h"
#include "contact/query/point/closest_point.h"
#include "contact/query/point/segment_hit.h"

namespace haptic {

/// Warm start of the queries about one object: what was hit by the first sweep of a leg, by a sweep
/// along one plane, and along several; and what was next to the proxy. It never changes a result.
struct ProxyWitness {
  std::array<SegmentWitness, 3> hit;
  ClosestWitness beside;
};

struct ProxyPlace {
  Vec3 g_W;  // verified position of its centre: outside every closed object by the radius
  bool seeded = false;
  PerObject<Pose> X_WO;  // object poses for which g_W was verified
};

/// State that survives a contact step.
struct PointProxy : ProxyPlace {
  std::array<ProxyWitness, kMaxObjects> witnesses{};
};

struct ProxyMove {
  std::array<ProxyPlane, 3> active{};
  uint32_t n_active = 0;
  double free_fraction = 1;  // share of the way from the old proxy to the tool
  uint32_t flags = 0;        // ContactFlag
};

/// Places the proxy at p_W or, if p_W is inside a closed object or nearer than the radius, at the
/// nearest place found, epsilon off. Sets kContactReseeded if it had to move, and
/// kContactNoFreePose if no free pose was found (then the proxy is not seeded).
uint32_t seed_proxy(const PointScene& scene, const Vec3& p_W, PointProxy& proxy);

/// One update of the proxy: carries it along with objects that ran into it, then slides it towards
/// the goal p_W: sweep; at a hit stop epsilon short and take the tangent plane of the obstacle
/// there; the next subgoal is the point nearest to p_W on the planes; repeat until there is no
/// progress. Every leg is swept, so the proxy never passes a front face, not even in wedges or thin
/// plates. A point (radius 0) meets facets; a sphere meets their configuration-space obstacles:
/// offset faces, edge cylinders, vertex spheres.
///
/// Beside a convex edge, and at a vertex that is neither convex nor concave, the free space is more
/// than the intersection of the planes that hold a point. The steepest way out of a cone of facets
/// lies in one of them or along the line of two. So a point that its planes hold tries each facet
/// within 32 epsilon, and each pair of them: the nearest place epsilon in front, and from there up
/// to 256 epsilon towards the place nearest to the tool. Where that is clear and ends nearer to the
/// tool a new leg begins; so the distance only falls. Sources: Zilles & Salisbury 1995 (the point);
/// Ruspini, Kolarov, Khatib 1997 (the loop over subgoals, the sphere). Deviation: planes are
/// dropped by the sign of their multiplier, and it converges within the step (the first paper needs
/// two ticks to cross a convex edge).
ProxyMove move_proxy(const PointScene& scene, const Vec3& p_W, PointProxy& proxy);

}  // namespace haptic
