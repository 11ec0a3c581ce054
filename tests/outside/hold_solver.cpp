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
  out.object_impulse_W = question.object_impulse_W;
  ContactPlanes planes;
  out.finite = carry_planes(question.contacts, question.scene.X_WO, 0, planes);
  if (!out.finite || planes.size == 0) return out;
  const HalfSpace& plane = planes.planes[0].full;
  const double depth = plane.offset - dot(plane.normal, question.X_WT.p);
  held.depth = depth > 0 ? std::max(held.depth, depth) : 0;
  out.n_pushing = depth > 0;
  out.X_WP.p += held.depth * plane.normal;
  out.F_W.f = question.coupling.translational_stiffness * held.depth * plane.normal;
  return out;
}

}  // namespace haptic
