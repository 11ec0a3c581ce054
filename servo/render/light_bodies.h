// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/render/kept_shares.h"

namespace haptic {

/// How stiff the coupling is towards each object, as a share of what is in force.
struct LightBodies {
  std::array<double, kMaxObjects> share;

  LightBodies() { share.fill(1); }
};

/// Softens what is rendered towards bodies that are too light for the coupling. A spring of
/// stiffness k that holds the effective mass m over a delay of T [s] gives energy beyond
///   k T² / m > kMostStiff,
/// T the periods of servo and sim together: sim answers a push a step of each later, and contacts,
/// corners and joints of the body only then. Along the wrench P with which an object pushes,
/// 1/k ~ Pᵀ C P with the compliance C of the coupling at the tool, and 1/m ~ Pᵀ M⁻¹ P with the
/// mobility M⁻¹ of the object and all that holds it (SceneFrame), so the force towards it and what
/// it is pushed with are kept by
///   s = min(1, kMostStiff Pᵀ C P / (T² Pᵀ M⁻¹ P)).
/// and by 1 − SceneObject::reduction, and to SceneObject::most_force, where a client moves it. The
/// share falls at once, and rises within kForget while the object does not push: a spring that
/// hardens while it is pressed gives energy, and what holds a light body, dry friction too, comes
/// and goes. What clients' planes on an object push counts with it. Returns whether the share is
/// below 1 of any object that pushes.
bool soften_towards_light(const ServoModel& model, const RenderQuestion& question,
                          const SceneFrame* scene, const Rendered& rendered, LightBodies& light,
                          KeptShares& shares);

}  // namespace haptic
