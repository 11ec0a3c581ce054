// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/point/shading.h"

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kMostSlope = 1;  // tangent of the largest angle between shading and true normal

}  // namespace

Vec3 limited_normal(const Vec3& shading, const Vec3& normal) {
  const double along = dot(shading, normal);
  const Vec3 sideways = shading - along * normal;
  const double size = norm(sideways);
  if (size == 0) return normal;
  const double slope = along * kMostSlope > size ? size / along : kMostSlope;
  return normalized(normal + (slope / size) * sideways);
}

Vec3 shaded_proxy(const PointProxySolution& solution, const PlanesInForce& planes,
                  const Vec3& tool_W, const std::array<Vec3, 3>& normals_W) {
  HAPTIC_ASSERT(static_cast<size_t>(solution.n_active) <= normals_W.size());
  PlanesInForce turned = planes;
  bool any = false;
  for (size_t i = 0; i < static_cast<size_t>(solution.n_active); ++i) {
    const ProxyPush& push = solution.pushes[i];
    HAPTIC_ASSERT(push.contact < planes.size);
    const Vec3& normal_W = push.plane.normal;
    if (normals_W[i] == normal_W) continue;
    const Vec3 m_W = limited_normal(normals_W[i], normal_W);
    const double depth = push.plane.offset - dot(normal_W, tool_W);
    turned.half_spaces[push.contact] = {m_W, dot(m_W, tool_W) + depth / dot(m_W, normal_W)};
    any = true;
  }
  if (!any) return solution.proxy_W;
  const PointProjection shaded = project_onto_half_spaces(tool_W, turned.view());
  if (!shaded.converged) return solution.proxy_W;
  const PointProjection true_place = project_onto_half_spaces(shaded.x, planes.view());
  return true_place.converged ? true_place.x : solution.proxy_W;
}

}  // namespace haptic
