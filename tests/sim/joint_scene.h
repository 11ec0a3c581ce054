// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

#include "proto/math/units.h"
#include "tests/sim/body_scene.h"

namespace haptic::test {

/// A rod along x whose middle is where its joint is not: the lever from the axis, at the origin, to
/// the middle is half its length.
struct RodScene : BodyScene {
  static constexpr double kMass = 0.2, kLength = 0.1, kSide = 0.02;  // [kg], [m]
  /// About the end [kg·m²], by the formula of a box.
  static constexpr double kInertia =
      kMass / 12 * (kLength * kLength + kSide * kSide) + kMass * kLength * kLength / 4;

  JointConfig& joint;

  explicit RodScene(JointKind kind) : joint(config.joints[0]) {
    add_box({kLength, kSide, kSide}, {{kLength / 2, 0, 0}, {}}, kMass);
    config.n_joints = 1;
    joint.kind = kind;
  }
};

/// A hand that pushes one object with a wrench that is constant from step to step.
struct PushingFrame {
  ServoFrame frame{};
  uint32_t response;

  explicit PushingFrame(BodySim& sim, uint32_t pushed = 0)
      : response(sim.frame.objects[pushed].response) {
    frame.pushes.resize(sim.frame.responses.size());
    frame.t_ns = frame.impulses_since_ns = sim.t_ns;
    sim.begin_with(frame);
  }
  /// The counters after another millisecond of this wrench at the object's origin.
  const ServoFrame* push(const Wrench& F_W) {
    auto& [J, S] = frame.pushes[response];
    S = S + kTick * J + 0.5 * kTick * kTick * F_W;
    J = J + kTick * F_W;
    frame.t_ns += 1'000'000;
    return &frame;
  }
};

/// Sets a sim back to where a joint's object has this pose and twist; the joint reads `position`.
inline void begin_at(BodySim& sim, const Pose& X_WO, const Twist& V_WO, double position) {
  SceneFrame last = sim.frame;
  last.objects[0].X_WO = X_WO;
  last.objects[0].V_WO = V_WO;
  last.joints[0].position = position;
  sim.state = {};
  resume(sim.model, sim.state, last);
  sim.frame = sim_step(sim.model, sim.state, last.t_ns);
}

/// A rod of RodScene turned by q about z.
inline Pose turned_rod(double q) {
  const double r = RodScene::kLength / 2;
  return {{r * std::cos(q), r * std::sin(q), 0}, from_rotation_vector({0, 0, q})};
}

}  // namespace haptic::test
