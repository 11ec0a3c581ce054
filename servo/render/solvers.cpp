// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/math/assert.h"
#include "servo/render/render.h"

namespace haptic {

#define RENDERER(id, name, detector, solver, ...) Render solver;
#include "proto/wire/renderers.def"

Render& render_of(Renderer renderer) {
  static constexpr std::array kSolvers{
#define RENDERER(id, name, detector, solver, ...) &solver,
#include "proto/wire/renderers.def"
  };
  HAPTIC_ASSERT(static_cast<size_t>(renderer) < kSolvers.size());
  return *kSolvers[static_cast<size_t>(renderer)];
}

}  // namespace haptic
