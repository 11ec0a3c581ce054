// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <initializer_list>
#include <memory>

#include "proto/math/units.h"
#include "servo/step.h"
#include "tests/support/frames.h"
#include "tests/support/near.h"

namespace haptic::test {

inline Contact plane(const Vec3& normal_O, const Vec3& point_O, double extent = 0.02) {
  Contact c{};
  c.normal_O = c.shading_normal_O = normal_O;
  c.object_point_O = point_O;
  c.extent = extent;
  return c;
}

inline std::unique_ptr<ContactSet> set_of(std::initializer_list<Contact> contacts) {
  auto set = std::make_unique<ContactSet>();
  *set = {};
  set->contacts.assign(contacts);
  set->n_active = static_cast<uint32_t>(contacts.size());
  set->objects.resize(1);
  return set;
}

/// Objects that stand still at the origin; a push could move them, but they are too heavy.
inline SceneFrame still_scene(uint32_t n_responses) {
  SceneFrame scene{};
  for (uint32_t i = 0; i < n_responses; ++i) {
    scene.objects.push_back(scene_object());
    add_response(scene, i);
  }
  return scene;
}

inline ServoModel plain_model(double stiffness) {
  ServoModel model;
  model.coupling = {stiffness, 0};
  model.limits.max_force = 100;
  model.limits.max_torque = 1;
  model.limits.soft_start = 0;
  model.limits.slew = 1e9;
  return model;
}

inline ServoInput input_at(int64_t tick, const Vec3& p_W, const ContactSet* set) {
  ServoInput input;
  input.tick = static_cast<uint64_t>(tick);
  input.t_ns = tick * kMs;
  input.device.X_BH.p = p_W;
  input.device.flags = kDeviceFresh | kDeviceHomed;
  input.contacts = set;
  return input;
}

/// One tick of an armed session that leaves the coupling unchanged.
inline ServoFrame step_armed(const ServoModel& model, ServoState& state, ServoInput input) {
  ControlFrame control{};
  control.armed = 1;
  control.translational_stiffness = model.coupling.translational_stiffness;
  control.translational_damping = model.coupling.translational_damping;
  control.rotational_stiffness = model.coupling.rotational_stiffness;
  control.rotational_damping = model.coupling.rotational_damping;
  if (input.control == nullptr) input.control = &control;
  return servo_step(model, state, input);
}

/// Whether the solver in use is of that type, and has begun.
template <class Solver>
bool is_started(const ServoState& state) {
  const auto* const kept = std::get_if<Solver>(&state.render.solver);
  return kept != nullptr && kept->state.started;
}

}  // namespace haptic::test
