// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/point/direct.h"

namespace haptic {

PointProxySolution solve_direct(const ProxyQuestion& question) {
  PointProxySolution out;
  out.proxy_W = question.tool_W;
  CarriedContacts carried = carry_contacts(question.contacts, question.scene);
  out.finite = carried.finite;
  if (!out.finite || question.scene.weight <= 0) return out;

  double pushes = 0, weighted = 0;
  for (CarriedContact& contact : carried.view()) {
    contact.weight = weight_at(contact, question.scene.aged_weight(contact), {&question.tool_W, 1});
    const HalfSpace half_space = relaxed(contact, question.radius, question.tool_W);
    const double depth = half_space.offset - dot(half_space.normal, question.tool_W);
    if (!(depth > 0) || out.n_active == static_cast<int>(out.pushes.size())) continue;
    const auto k = static_cast<uint32_t>(&contact - carried.contacts.data());
    out.add(question.contacts, k, contact.object, half_space, depth);
    out.proxy_W += depth * half_space.normal;
    pushes += depth;
    weighted += depth * contact.weight;
  }
  out.share = pushes > 0 ? weighted / pushes : 0;
  return out;
}

}  // namespace haptic
