// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/query/triangle/closest_on_triangle.h"
#include "contact/shape/baked/mesh_shape.h"
#include "proto/wire/per_object.h"

namespace haptic {

/// The objects at one instant, for a point detector.
struct PointScene {
  std::span<const MeshShape> shapes;
  PerObject<Pose> X_WO;
  double epsilon = 1e-7;  // distance of the verified proxy from every surface [m]
  double radius = 0;      // of the proxy; 0: a point [m]
};

/// A facet in the active set: with its face or, for a sphere, with one of its edges or vertices.
struct ProxyPlane {
  uint32_t object = 0;
  uint32_t triangle = 0;
  bool operator==(const ProxyPlane&) const = default;
};

/// The support of the proxy at g_W on this facet: for a point, the facet's plane; for a sphere, the
/// point of the facet nearest to the centre, with the normal from there to the centre.
struct ProxySupport {
  Feature feature;
  Vec3 point_O;
  Vec3 normal_O;  // unit, towards the proxy
};
ProxySupport support_of(const PointScene& scene, const ProxyPlane& plane, const Vec3& g_W);

}  // namespace haptic
