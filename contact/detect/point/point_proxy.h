// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

#include "contact/query/point/closest_point.h"
#include "contact/query/point/segment_hit.h"
#include "contact/shape/baked/mesh_shape.h"
#include "proto/wire/wire.h"

namespace haptic {

/// The objects at one instant, for a point detector.
struct PointScene {
  std::span<const MeshShape> shapes;
  std::array<Pose, kMaxObjects> X_WO;
  double epsilon = 1e-7;  // distance of the verified proxy from every surface [m]
  double radius = 0;      // of the proxy; 0: a point [m]
};

/// Warm start of the queries about one object: what was hit by the first sweep of a leg, by a sweep
/// along one plane, and along several; and what was next to the proxy. It never changes a result.
struct ProxyWitness {
  std::array<SegmentWitness, 3> hit;
  ClosestWitness beside;
};

struct ProxyPlace {
  Vec3 g_W;  // verified position of its centre: outside every closed object by the radius
  bool seeded = false;
  std::array<Pose, kMaxObjects> X_WO;  // object poses for which g_W was verified
};

/// State that survives a contact step.
struct PointProxy : ProxyPlace {
  std::array<ProxyWitness, kMaxObjects> witnesses{};
};

/// A facet in the active set: with its face or, for a sphere, with one of its edges or vertices.
struct ProxyPlane {
  uint32_t object = 0;
  uint32_t triangle = 0;
  bool operator==(const ProxyPlane&) const = default;
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
/// offset faces, edge cylinders, vertex spheres. At a vertex that is neither convex nor concave the
/// free space is no intersection of half-spaces: a point held by planes there is taken around the
/// vertex to where the steepest direction begins (VertexFan), 1000 epsilon off, and back if that
/// led it no nearer. Sources: Zilles & Salisbury 1995 (the point); Ruspini, Kolarov, Khatib 1997
/// (the loop over subgoals, the sphere). Deviation: planes are dropped by the sign of their
/// multiplier, and it converges within the step (the first paper needs two ticks to cross a convex
/// edge).
ProxyMove move_proxy(const PointScene& scene, const Vec3& p_W, PointProxy& proxy);

/// The support of the proxy at g_W on this facet: for a point, the facet's plane; for a sphere, the
/// point of the facet nearest to the centre, with the normal from there to the centre.
struct ProxySupport {
  Feature feature;
  Vec3 point_O;
  Vec3 normal_O;  // unit, towards the proxy
};
ProxySupport support_of(const PointScene& scene, const ProxyPlane& plane, const Vec3& g_W);

}  // namespace haptic
