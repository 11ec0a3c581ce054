// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/render/solvers.h"

#include "proto/wire/renderer.h"

namespace haptic {
namespace {

template <class Solver>
Rendered rendered_with(const ServoModel& model, const RenderQuestion& question,
                       RenderState& state) {
  auto* solver = std::get_if<Solver>(&state.solver);
  if (solver == nullptr) solver = &state.solver.emplace<Solver>();
  return solver->render(model, question, state.contact_solvers);
}

}  // namespace

Rendered rendered_by(Renderer renderer, const ServoModel& model, const RenderQuestion& question,
                     RenderState& state) {
  switch (renderer) {
#define RENDERER(id, name, detector, solver, ...) \
  case Renderer::id:                              \
    return rendered_with<solver>(model, question, state);
#include "proto/wire/renderers.def"
  }
  return {};
}

}  // namespace haptic
