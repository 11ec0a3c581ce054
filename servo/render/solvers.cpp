// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/render/solvers.h"

#include <type_traits>

#include "proto/math/assert.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr size_t kMostOfSolver = 16 * 1024;  // [bytes]: the state of a servo stays in its cache

template <class Solver>
Rendered rendered_with(const ServoModel& model, const RenderQuestion& question,
                       RenderState& state) {
  // begun and dropped within a tick: it must neither allocate nor throw
  static_assert(std::is_nothrow_default_constructible_v<Solver> &&
                std::is_trivially_copyable_v<Solver> && sizeof(Solver) <= kMostOfSolver);
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
  HAPTIC_ASSERT(false);
  return {};
}

}  // namespace haptic
