// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/model.h"

#include <algorithm>

#include "proto/config/devices.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

SoftProxyModel soft_model(const SessionConfig& config) {
  SoftProxyModel soft;
  soft.integrator = config.proxy.integrator;
  soft.contact_stiffness = config.proxy.contact_stiffness;
  soft.contact_damping = config.proxy.contact_damping;
  // a point moves at most half the band in a tick, so that none passes it unseen; without a field
  // a voxel, as McNeely has it
  soft.max_travel = config.voxel.field != 0 ? 0.5 * config.voxel.band : config.voxel.size;
  return soft;
}

/// The scene of an admittance device is as hard as the device: nothing may hold a body back from a
/// wall, or let it into one.
void show_body(const SessionConfig& config, ServoModel& model) {
  model.admittance = config.device.admittance;
  model.coupling.max_force = model.coupling.max_torque = 0;
  for (MaterialConfig& material : model.materials.of_object) material.stiffness_share = 1;
}

}  // namespace

ServoModel build_servo_model(const SessionConfig& config, const ActuatorLimits& device) {
  HAPTIC_ASSERT(config.servo_rate > 0 && config.n_objects <= kMaxObjects);
  HAPTIC_ASSERT(device.max_force >= 0 && device.max_torque >= 0);
  ServoModel model;
  model.hand = config.hand;
  model.dt = 1 / config.servo_rate;
  model.sim_period = 1 / config.sim_rate;
  model.map = config.map;
  model.coupling = config.coupling;
  // a recorded hand is not in the loop
  if (!row_of(config.device.kind).is_recorded) {
    model.moving = moving_axis(config);
    if (config.device.max_torque > 0 && can_turn(config.device))
      model.turning = turning_axis(config);
  }
  model.dead_man_button = config.safety.dead_man_button;
  model.renderer = config.renderer;
  model.proxy_radius = config.proxy_radius;
  model.materials.images = config.images;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    model.materials.of_object[i] = config.objects[i].material;
  }
  for (uint32_t c = 0; c < config.n_clients; ++c) {
    model.clients[c] = {config.clients[c].max_force, config.clients[c].max_power};
  }
  model.proxy = config.proxy;
  model.constrained6.solver = config.rigid.solver;
  model.soft = soft_model(config);
  model.tool.mass = config.tool.mass;
  SafetyLimits& limits = model.limits;
  limits.max_force = std::min(config.safety.max_force, device.max_force);
  limits.max_torque = std::min(config.safety.max_torque, device.max_torque);
  limits.soft_start = config.safety.soft_start;
  limits.continuous_force = config.device.continuous_force;
  limits.continuous_torque = config.device.continuous_torque;
  limits.slew = config.safety.slew;
  limits.torque_slew = config.safety.torque_slew;
  limits.velocity_limit = config.safety.velocity_limit;
  limits.angular_velocity_limit = config.safety.angular_velocity_limit;
  limits.workspace_centre_B = config.device.workspace_centre_B;
  limits.workspace_radius = config.device.workspace_radius;
  limits.workspace_rest_B = config.device.workspace_rest_B;
  limits.workspace_turn = config.device.workspace_turn;
  limits.max_damping = config.device.max_damping;
  limits.max_rotational_damping = config.device.max_rotational_damping;
  if (device.is_admittance) show_body(config, model);
  return model;
}

}  // namespace haptic
