// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

#include "contact/query/point/closest_point.h"
#include "contact/query/point/segment_hit.h"
#include "contact/shape/baked/mesh_shape.h"
#include "proto/wire/wire.h"

namespace haptic {

/// The objects at this instant, for a point detector.
struct PointScene {
  std::span<const MeshShape> shapes;
  std::array<Pose, kMaxObjects> X_WO;
  double epsilon = 1e-7;  // how far the verified proxy keeps off every surface [m]
  double radius = 0;      // of the proxy; 0: a point [m]
};

/// Where the last queries about one object ended, the likely answers of the next ones: what was hit
/// by a sweep that begins a leg, by one along one plane, and by one along more; and what was next
/// to the proxy. They never change a result.
struct ProxyWitness {
  std::array<SegmentWitness, 3> hit;
  ClosestWitness beside;
};

/// Where a proxy is.
struct ProxyPlace {
  Vec3 g_W;  // verified position of its centre: outside every closed object, radius away
  bool seeded = false;
  std::array<Pose, kMaxObjects> X_WO;  // object poses at which g was verified
};

/// What survives between two contact steps.
struct PointProxy : ProxyPlace {
  std::array<ProxyWitness, kMaxObjects> witnesses{};
};

/// A facet that carries the proxy, with its face, or, for a sphere, with an edge or a vertex.
struct ProxyPlane {
  uint32_t object = 0;
  uint32_t triangle = 0;
  bool operator==(const ProxyPlane&) const = default;
};

struct ProxyMove {
  std::array<ProxyPlane, 3> active{};
  uint32_t n_active = 0;
  double free_fraction = 1;  // of the way from the old proxy to the tool
  uint32_t flags = 0;        // ContactFlag
};

/// Places the proxy at p_W, or, where p_W is inside a closed object or nearer than the radius, at
/// the nearest place found, epsilon off. Sets kContactReseeded when it had to move,
/// kContactNoFreePose when no free pose was found (then the proxy is not seeded).
uint32_t seed_proxy(const PointScene& scene, const Vec3& p_W, PointProxy& proxy);

/// One update of the proxy: carries it with objects that ran into it, then slides it towards the
/// goal p_W: sweep; at a hit stop epsilon short and take the tangent plane of the obstacle there;
/// the next subgoal is the point nearest to p_W on the planes; repeat until nothing is gained.
/// Every leg is swept, so the proxy never passes a front face, in wedges and on thin plates too. A
/// point (radius 0) meets facets; a sphere meets their obstacles in configuration space: offset
/// faces, edge cylinders, vertex spheres. At a vertex that is neither convex nor concave what is
/// free is no intersection of half-spaces: a point that planes hold there goes around the vertex to
/// where the steepest way begins (VertexFan), 1000 epsilon off, and back if that led it no nearer.
/// Sources: Zilles & Salisbury 1995 (the point); Ruspini, Kolarov, Khatib 1997 (the loop over
/// subgoals, the sphere). Deviation: planes are dropped by multiplier sign, and convergence is
/// reached within the step (the first paper needs two ticks to cross a convex edge).
ProxyMove move_proxy(const PointScene& scene, const Vec3& p_W, PointProxy& proxy);

/// What carries the proxy at g_W on this facet: the facet's own plane for a point; for a sphere the
/// point of the facet nearest to the centre, with the normal from there to the centre.
struct ProxySupport {
  Feature feature;
  Vec3 point_O;
  Vec3 normal_O;  // unit, towards the proxy
};
ProxySupport support_of(const PointScene& scene, const ProxyPlane& plane, const Vec3& g_W);

}  // namespace haptic
