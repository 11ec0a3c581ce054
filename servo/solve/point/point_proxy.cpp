// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/point/point_proxy.h"

#include "proto/math/assert.h"

namespace haptic {

PointProxySolution solve_point_proxy(const ProxyQuestion& question, PlanesInForce& planes) {
  HAPTIC_ASSERT(question.weight <= 1);
  PointProxySolution out;
  out.proxy_W = question.tool_W;
  planes.size = 0;
  ContactPlanes carried;
  out.finite = carry_planes(question.contacts, question.X_WO, question.radius, carried);
  if (!out.finite || question.weight <= 0) return out;

  const Vec3& tool_W = question.tool_W;
  planes.size = carried.size;
  for (size_t i = 0; i < carried.size; ++i) {
    carried.planes[i].weight = question.weight;
    planes.half_spaces[i] = relaxed(carried.planes[i], tool_W);
  }
  PointProjection projection = project_onto_half_spaces(tool_W, planes.view());

  // relaxes planes whose extent contains neither the tool nor the proxy
  const std::array<Vec3, 3> places_W{tool_W, projection.x, tool_W + question.held_back_W};
  bool faded = false;
  for (size_t i = 0; i < carried.size; ++i) {
    ContactPlane& plane = carried.planes[i];
    const double w = extent_weight(plane, places_W);
    if (w >= 1) continue;
    plane.weight = w * question.weight;
    planes.half_spaces[i] = relaxed(plane, tool_W);
    faded = true;
  }
  if (faded) projection = project_onto_half_spaces(tool_W, planes.view());

  out.converged = projection.converged;
  out.proxy_W = projection.x;
  out.n_active = projection.n_active;
  double pushes = 0, weighted = 0;
  for (size_t i = 0; i < static_cast<size_t>(projection.n_active); ++i) {
    const auto k = static_cast<size_t>(projection.active[i]);
    HAPTIC_ASSERT(k < carried.size);
    const double multiplier = projection.multiplier[i];
    out.pushes[i] = {carried.planes[k].object, static_cast<uint32_t>(k),
                     question.contacts.contacts[k].feature, planes.half_spaces[k],
                     multiplier * planes.half_spaces[k].normal};
    pushes += multiplier;
    weighted += multiplier * carried.planes[k].weight;
  }
  out.share = pushes > 0 ? weighted / pushes : 0;
  return out;
}

PointProxySolution solve_point_proxy(const ContactSet& contacts,
                                     const std::array<Pose, kMaxObjects>& X_WO, const Vec3& tool_W,
                                     double weight) {
  PlanesInForce planes;
  return solve_point_proxy({contacts, X_WO, tool_W, weight, 0, {}}, planes);
}

}  // namespace haptic
