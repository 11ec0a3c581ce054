// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/config/renderer_needs.h"
#include "proto/wire/wire.h"

namespace haptic {

/// The ControlFrame a session starts with: revision 1, as configured.
inline ControlFrame initial_control(const SessionConfig& config) {
  ControlFrame control{};
  control.revision = 1;
  control.translational_stiffness = config.coupling.translational_stiffness;
  control.translational_damping = config.coupling.translational_damping;
  control.rotational_stiffness = config.coupling.rotational_stiffness;
  control.rotational_damping = config.coupling.rotational_damping;
  control.scene_time_scale = 1;
  control.armed = config.safety.armed_at_start;
  control.renderer = static_cast<uint32_t>(config.renderer);
  control.solver = number_of(solver_of(config.proxy, config.renderer));
  return control;
}

}  // namespace haptic
