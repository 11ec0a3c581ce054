// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/render/any_solver.h"  // made of the renderers' lines: renderer_types.cmake
#include "servo/render/render.h"

namespace haptic {

/// What rendering keeps between ticks.
struct RenderState {
  AnySolver solver;                // that of the last tick; none: the next one begins anew
  ContactSolvers contact_solvers;  // memory of rigid ones; nothing persists in it

  void forget() { solver = {}; }
};

/// This tick's proxy and the coupling's wrench, by the solver of a renderer, a class of any
/// *_solver.h of this folder that the line in proto/wire/renderers.def names. It is copyable,
/// starts without arguments, and has
///   Rendered render(const ServoModel& model, const RenderQuestion& question,
///                   ContactSolvers& solvers)
/// which allocates nothing and never throws. Another one than in the last tick begins anew.
Rendered rendered_by(Renderer renderer, const ServoModel& model, const RenderQuestion& question,
                     RenderState& state);

}  // namespace haptic
