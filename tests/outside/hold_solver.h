// SPDX-License-Identifier: GPL-3.0-or-later
// Solver of the renderer "hold": while the tool touches, the force of the deepest place so far.
#pragma once

#include <algorithm>

#include "servo/render/render.h"

namespace haptic {

struct HoldSolver {
  double deepest = 0;  // [m]

  Rendered render(const ServoModel&, const RenderQuestion& question, ContactSolvers&) {
    Rendered out(question.scene);
    out.X_WP = question.X_WT;
    const CarriedContacts carried = carry_contacts(question.contacts, question.scene);
    out.finite = carried.finite;
    if (carried.size == 0) return out;
    const Vec3& normal_W = carried.contacts[0].normal_W;
    const double depth = dot(normal_W, carried.contacts[0].point_W - question.X_WT.p);
    deepest = depth > 0 ? std::max(deepest, depth) : 0;
    out.n_pushing = depth > 0;
    out.X_WP.p += deepest * normal_W;
    out.F_W.f = question.coupling.translational_stiffness * deepest * normal_W;
    return out;
  }
};

}  // namespace haptic
