// SPDX-License-Identifier: GPL-3.0-or-later
// Solver of the renderer "hold": while the tool touches, the force of the deepest place so far.
#include <algorithm>

#include "servo/render/render.h"

namespace haptic {
namespace {

struct Held {
  double depth = 0;  // [m]
};

}  // namespace

Rendered render_hold(const ServoModel&, const RenderQuestion& question, RenderState& state) {
  Held& held = state.kept.keep<Held>();
  Rendered out;
  out.X_WP = question.X_WT;
  const CarriedContacts carried = carry_contacts(question.contacts, question.scene);
  out.finite = carried.finite;
  if (carried.size == 0) return out;
  const Vec3& normal_W = carried.contacts[0].normal_W;
  const double depth = dot(normal_W, carried.contacts[0].point_W - question.X_WT.p);
  held.depth = depth > 0 ? std::max(held.depth, depth) : 0;
  out.n_pushing = depth > 0;
  out.X_WP.p += held.depth * normal_W;
  out.F_W.f = question.coupling.translational_stiffness * held.depth * normal_W;
  return out;
}

}  // namespace haptic
