// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/point/direct.h"

#include "proto/math/assert.h"

namespace haptic {

PointProxySolution solve_direct(const ProxyQuestion& question) {
  HAPTIC_ASSERT(question.weight <= 1);
  PointProxySolution out;
  out.proxy_W = question.tool_W;
  ContactPlanes carried;
  out.finite = carry_planes(question.contacts, question.X_WO, question.radius, carried);
  if (!out.finite || question.weight <= 0) return out;

  double pushes = 0, weighted = 0;
  for (ContactPlane& plane : carried.view()) {
    plane.weight = question.weight * extent_weight(plane, {&question.tool_W, 1});
    const HalfSpace half_space = relaxed(plane, question.tool_W);
    const double depth = half_space.offset - dot(half_space.normal, question.tool_W);
    if (!(depth > 0) || out.n_active == static_cast<int>(out.pushes.size())) continue;
    const auto k = static_cast<uint32_t>(&plane - carried.planes.data());
    out.pushes[static_cast<size_t>(out.n_active++)] = {plane.object, k,
                                                       question.contacts.contacts[k].feature,
                                                       half_space, depth * half_space.normal};
    out.proxy_W += depth * half_space.normal;
    pushes += depth;
    weighted += depth * plane.weight;
  }
  out.share = pushes > 0 ? weighted / pushes : 0;
  return out;
}

}  // namespace haptic
