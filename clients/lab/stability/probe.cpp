// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/stability/probe.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "proto/config/devices.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

// limits beyond whatever the bench makes
constexpr double kAnyForce = 1e5;   // [N]
constexpr double kAnyTorque = 1e4;  // [N·m]
constexpr double kAnySlew = 1e9;    // [N/s or N·m/s]
constexpr double kAnySpeed = 1e6;   // [m/s or rad/s]

constexpr double kBlock = 0.1;      // edge of the block [m]
constexpr double kFirstGap = 2e-6;  // of the tool over it at the beginning [m]

// how a cube is pressed while it turns: by an axis that is far from its own limit, 2b/T = 10 kN/m,
// and does not take part
constexpr double kCubeStiffness = 1000;  // [N/m]
constexpr double kCubeMass = 0.1;        // [kg]
constexpr double kCubeDamping = 5;       // [N·s/m]

SessionConfig scene_of(bool turning) {
  SessionConfig config;
  assign(config.name, turning ? "a cube on a block" : "a point on a block");
  config.renderer = turning ? Renderer::kConstrained6 : Renderer::kGodObject3;
  config.n_objects = 1;
  config.objects[0].primitive = primitive::Box{{kBlock, kBlock, kBlock}};
  config.objects[0].X_WO.p = {0, 0, -0.5 * kBlock};
  if (!turning) return config;
  constexpr double kEdge = 2 * kHalfCube;
  config.tool.primitive = primitive::Box{{kEdge, kEdge, kEdge}};
  config.tool.mass = kCubeMass;
  config.rigid.margin = 1e-6;
  return config;
}

void widen(SafetyConfig& safety) {
  safety.soft_start = 0;
  safety.max_force = kAnyForce;
  safety.max_torque = kAnyTorque;
  safety.slew = safety.torque_slew = kAnySlew;
  safety.velocity_limit = safety.angular_velocity_limit = kAnySpeed;
}

Vec3 quantised(const Vec3& a, double step) {
  if (!(step > 0)) return a;
  const auto below = [step](double x) { return step * std::floor(x / step); };
  return {below(a.x), below(a.y), below(a.z)};
}

}  // namespace

ProbedBody probed_body(const ProbeSetting& setting) {
  const SimulatedHandConfig& hand = setting.hand;
  if (setting.turning) {
    return {hand.inertia + hand.hand_inertia,
            hand.rotational_damping + hand.hand_rotational_damping, hand.hand_rotational_stiffness};
  }
  return {hand.mass + hand.hand_mass, hand.damping + hand.hand_damping, hand.hand_stiffness};
}

ProbeScene::ProbeScene(bool turning) : turning_(turning), baked_(bake_session(scene_of(turning))) {}

SessionConfig ProbeScene::session(const ProbeSetting& setting) const {
  SessionConfig config = scene_of(turning_);
  config.servo_rate = setting.rate;
  widen(config.safety);
  Coupling& coupling = config.coupling;
  DeviceConfig& device = config.device;
  device.hand = setting.hand;
  if (turning_) {
    coupling.translational_stiffness = kCubeStiffness;
    coupling.rotational_stiffness = setting.stiffness;
    coupling.rotational_damping = setting.damping;
    device.hand.mass = kCubeMass;
    device.hand.damping = kCubeDamping;
    device.hand.coulomb_friction = device.hand.encoder_step = 0;
    device.hand.hand_mass = device.hand.hand_damping = device.hand.hand_stiffness = 0;
  } else {
    coupling.translational_stiffness = setting.stiffness;
    coupling.translational_damping = setting.damping;
    device.hand.inertia = 0;
  }
  // the handle begins at the origin of B: there it does not touch yet
  config.map.X_WB.p.z = turning_ ? kHalfCube + kFirstGap : kFirstGap;
  device.kind = DeviceKind::kSimulatedHand;
  device.max_force = kAnyForce;
  device.max_torque = turning_ ? kAnyTorque : 0;
  device.max_damping = setting.is_controlled ? setting.max_damping : 0;
  device.max_rotational_damping = setting.is_controlled ? setting.max_rotational_damping : 0;
  return config;
}

DeviceCaps LedHandle::caps() const {
  return {.max_force = kAnyForce,
          .max_torque = seen_.inertia > 0 ? kAnyTorque : 0,
          .open_loop = true,
          .simulated = true};
}

bool LedHandle::read(const TickTime& tick, DeviceState& state) {
  const Pose X_B = path_(tick_);
  const Vec3 turn_B = quantised(to_rotation_vector(X_B.q), seen_.angle_step);
  state = {};
  state.t_ns = tick.now_ns;
  state.X_BH = {quantised(X_B.p, seen_.encoder_step), from_rotation_vector(turn_B)};
  if (tick_ > 0) {
    // as of any simulated hand: the backward difference, then one pole
    const double dt = 1e-9 * static_cast<double>(tick.now_ns - last_.t_ns);
    const double pole = 1 / (2 * std::numbers::pi * seen_.velocity_cutoff);
    const double share = dt / (dt + pole);
    const Twist& before = last_.V_BH;
    const Vec3 v_B = (state.X_BH.p - last_.X_BH.p) / dt;
    const Vec3 w_B = to_rotation_vector(state.X_BH.q * conjugate(last_.X_BH.q)) / dt;
    state.V_BH = {before.v + share * (v_B - before.v), before.w + share * (w_B - before.w)};
  }
  state.flags = kDeviceFresh | kDeviceHomed | kDeviceOpenLoop | kDeviceSimulated;
  last_ = state;
  ++tick_;
  return true;
}

}  // namespace haptic
