// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "proto/config.h"
#include "proto/wire.h"

namespace haptic {

/// The smaller of what the device can do and what the config allows, in device units.
struct SafetyLimits {
  double max_force = 0;     // [N]
  double max_torque = 0;    // [N·m]; 0: the torque is dropped, and said
  double soft_start = 0.5;  // ramp from zero to full force [s]
};

struct SafetyState {
  double gain = 0;     // soft start
  bool fault = false;  // latched until fault_clears grows
  uint64_t fault_clears = 0;
};

struct SafetyInput {
  Wrench F_B;                 // what the solver asks for, on the handle, in B
  bool input_finite = true;   // device sample and contacts held no NaN or infinity
  bool force_closed = false;  // clutch held, paused or no free proxy pose: zero, then soft start
  bool restart = false;       // the proxy was placed anew: soft start from the present pose
  uint64_t fault_clears = 0;  // of the ControlFrame in force
};

struct SafetyOutput {
  Wrench F_B;
  uint32_t flags = 0;  // ServoFlag
};

/// The last stage before the device; runs after every solver and cannot be switched off. Order:
/// finite check (latched fault, zero wrench), soft-start gain, saturation with the direction kept.
/// The fade of stale contacts is in weigh_contacts, before it.
SafetyOutput make_safe(const SafetyLimits& limits, SafetyState& state, const SafetyInput& input,
                       double dt);

}  // namespace haptic
