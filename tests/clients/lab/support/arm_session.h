// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <vector>

#include "clients/lockstep/lockstep.h"
#include "contact/shape/baked/mesh_shape.h"
#include "device-io/arm/simulated_arm.h"
#include "proto/config/devices.h"

namespace haptic::test {

/// A session with a simulated arm at full force from the start, and nothing that limits it but the
/// sizes of force and torque.
inline SessionConfig arm_session(Renderer renderer) {
  SessionConfig config;
  config.renderer = renderer;
  config.n_objects = 1;
  config.coupling.rotational_stiffness = 2;
  config.safety.soft_start = 0;
  config.safety.slew = 1e9;
  config.safety.max_force = 100;
  config.safety.max_torque = 10;
  config.safety.velocity_limit = 5;
  config.safety.angular_velocity_limit = 50;
  config.device.kind = DeviceKind::kSimulatedArm;
  config.device.max_force = config.safety.max_force;
  config.device.max_torque = config.safety.max_torque;
  return config;
}

/// An arm, and the steps of servo, contact and sim around it: one object at config's pose of it,
/// and a tool where it is a body.
struct ArmRun {
  std::vector<MeshShapeData> owned;
  ContactShapes shapes;
  SimulatedArm arm;
  Lockstep lockstep;

  ArmRun(const SessionConfig& config, std::vector<Soup> object_and_tool, Intention intention,
         const LockstepOptions& options = {})
      : owned(built(std::move(object_and_tool))),
        shapes(shapes_of(owned)),
        arm(config.device, std::move(intention)),
        lockstep(config, shapes, arm, options) {}

  const ServoFrame& step() {
    lockstep.step();
    return lockstep.frame();
  }

 private:
  static std::vector<MeshShapeData> built(std::vector<Soup> soups) {
    std::vector<MeshShapeData> out;
    for (Soup& soup : soups) out.push_back(build_shape(std::move(soup)));
    return out;
  }
  static ContactShapes shapes_of(const std::vector<MeshShapeData>& owned) {
    ContactShapes out(std::array{owned[0].view()});
    if (owned.size() > 1) out.bodies.tool = owned[1].view();
    return out;
  }
};

}  // namespace haptic::test
