// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/step.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/wire/scene_pose.h"
#include "sim/scene.h"

namespace haptic {
namespace {

// no time has passed at the first step; after an outage at most the readers' extrapolation
int64_t elapsed_ns(const SimState& state, int64_t t_ns) {
  if (!state.started) return 0;
  const int64_t elapsed = std::max<int64_t>(0, t_ns - state.t_ns);
  return state.resumed ? std::min(elapsed, kExtrapolationNs) : elapsed;
}

void note_bodies_pushes(const SimModel& model, SimState& state, double dt) {
  if (!state.bodies.world) return;
  for (size_t k = 0; k < model.given.objects.size(); ++k) {
    const uint32_t object = model.given.objects[k].object;
    push_by_bodies(state.given, k, state.bodies.world->take_pushed_by_bodies(object), dt);
  }
}

}  // namespace

SimModel build_sim(const SessionConfig& config, std::span<const MeshShape> shapes,
                   std::span<const PieceTree> pieces) {
  SimModel model{
      config.n_objects, config.n_hands, config.objects, build_bodies(config, shapes, pieces), {}};
  model.given = build_given(config, static_cast<uint32_t>(model.bodies.with_mass.size()));
  return model;
}

SceneFrame sim_step(const SimModel& model, SimState& state, int64_t t_ns, double time_scale) {
  return sim_step(model, state, HandFrames{}, t_ns, time_scale);
}

SceneFrame sim_step(const SimModel& model, SimState& state, const HandFrames& hands, int64_t t_ns,
                    double time_scale) {
  HAPTIC_ASSERT(model.n_objects <= kMaxObjects && time_scale >= 0);
  const int64_t elapsed = elapsed_ns(state, t_ns);
  // exact for scale 1; otherwise rounded to a nanosecond of scene time
  state.scene_ns += std::llround(time_scale * static_cast<double>(elapsed));
  state.t_ns = state.started && !state.resumed ? std::max(state.t_ns, t_ns) : t_ns;
  state.started = true;
  state.resumed = false;

  SceneFrame frame{};
  frame.seq = ++state.seq;
  frame.t_ns = state.t_ns;
  frame.n_hands = model.n_hands;
  frame.objects.resize(model.n_objects);
  const double scene_time = 1e-9 * static_cast<double>(state.scene_ns);
  for (uint32_t i = 0; i < model.n_objects; ++i) {
    const ObjectConfig& object = model.objects[i];
    const double speed = phase_speed(object.motion);
    const ScriptedState scripted =
        scripted_state(object, state.first_phase[i] + speed * scene_time, time_scale * speed);
    frame.objects[i] = {.X_WO = scripted.X_WO,
                        .V_WO = scripted.V_WO,
                        .t_ns = frame.t_ns,
                        .extrapolation_ns = kExtrapolationNs,
                        .reduction = 0,
                        .most_force = 0,
                        .response = kNoResponse,
                        .mover = kMovedBySim};
  }
  if (!model.given.objects.empty()) {
    step_given(model.given, state.given, {hands.data(), hands.size()}, frame);
  }
  if (!model.bodies.with_mass.empty()) step_bodies(model.bodies, state.bodies, hands, frame);
  if (!model.given.objects.empty()) {
    note_bodies_pushes(model, state, 1e-9 * static_cast<double>(elapsed));
    note_given(model.given, state.given, frame);
  }
  return frame;
}

void resume(const SimModel& model, SimState& state, const SceneFrame& last) {
  HAPTIC_ASSERT(!state.started);
  state.seq = last.seq;
  // a ring may hold anything
  if (!is_of(model.bodies, model.n_objects, model.given.objects.size(), last) ||
      last.n_hands != model.n_hands)
    return;
  state.t_ns = last.t_ns;
  state.started = true;
  state.resumed = true;
  state.bodies.resumed = true;
  state.bodies.last = last;
  resume_given(model.given, state.given, last);
  for (uint32_t i = 0; i < model.n_objects; ++i) {
    const SceneObject& object = last.objects[i];
    state.first_phase[i] = phase_of(model.objects[i], object.X_WO, object.V_WO);
  }
}

}  // namespace haptic
