// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/point/point_proxy.h"

#include "proto/math/assert.h"

namespace haptic {

HalfSpace relaxed(const CarriedContact& contact, double radius, const Vec3& tool_W) {
  HAPTIC_ASSERT(contact.weight >= 0 && contact.weight <= 1 && radius >= 0);
  const Vec3& n = contact.normal_W;
  HalfSpace half_space{n, dot(n, contact.point_W) + radius};
  const double depth = half_space.offset - dot(n, tool_W);
  if (depth > 0 && contact.weight < 1) half_space.offset -= (1 - contact.weight) * depth;
  return half_space;
}

PointProxySolution solve_point_proxy(const ProxyQuestion& question, PlanesInForce& planes) {
  PointProxySolution out;
  out.proxy_W = question.tool_W;
  planes.size = 0;
  CarriedContacts carried = carry_contacts(question.contacts, question.scene);
  out.finite = carried.finite;
  if (!out.finite || question.scene.weight <= 0) return out;

  const Vec3& tool_W = question.tool_W;
  planes.size = carried.size;
  for (size_t i = 0; i < carried.size; ++i) {
    planes.half_spaces[i] = relaxed(carried.contacts[i], question.radius, tool_W);
  }
  PointProjection projection = project_onto_half_spaces(tool_W, planes.view());

  // relaxes planes whose extent contains neither the tool nor the proxy
  const std::array<Vec3, 3> places_W{tool_W, projection.x, tool_W + question.held_back_W};
  bool faded = false;
  for (size_t i = 0; i < carried.size; ++i) {
    CarriedContact& contact = carried.contacts[i];
    const double weight = weight_at(contact, question.scene.aged_weight(contact), places_W);
    if (weight >= contact.weight) continue;
    contact.weight = weight;
    planes.half_spaces[i] = relaxed(contact, question.radius, tool_W);
    faded = true;
  }
  if (faded) projection = project_onto_half_spaces(tool_W, planes.view());

  out.converged = projection.converged;
  out.proxy_W = projection.x;
  double pushes = 0, weighted = 0;
  for (size_t i = 0; i < static_cast<size_t>(projection.n_active); ++i) {
    const auto k = static_cast<size_t>(projection.active[i]);
    HAPTIC_ASSERT(k < carried.size);
    const double multiplier = projection.multiplier[i];
    out.add(question.contacts, static_cast<uint32_t>(k), carried.contacts[k].object,
            planes.half_spaces[k], multiplier);
    pushes += multiplier;
    weighted += multiplier * carried.contacts[k].weight;
  }
  out.share = pushes > 0 ? weighted / pushes : 0;
  return out;
}

}  // namespace haptic
