// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <catch2/catch.hpp>
#include <functional>
#include <utility>

#include "clients/lockstep/lockstep.h"
#include "contact/shape/baked/mesh_shape.h"
#include "tests/support/workload.h"

namespace haptic::test {

/// Runs a scripted hand on one object in lockstep, and calls `see` with each frame and its
/// contacts.
inline void run(const SessionConfig& config, Soup soup, std::function<Vec3(double)> path,
                double seconds, const LockstepOptions& options,
                const std::function<void(const ServoFrame&, const ContactSet*)>& see) {
  const MeshShapeData owned = build_shape(std::move(soup));
  const std::array<MeshShape, 1> shapes{owned.view()};
  ScriptedHand hand(std::move(path));
  Lockstep lockstep(config, shapes, hand, options);
  const auto ticks = static_cast<int>(seconds * config.servo_rate);
  for (int k = 0; k < ticks; ++k) {
    REQUIRE(lockstep.step());
    see(lockstep.frame(), lockstep.contacts());
  }
}

/// The block whose top is z = 0.
inline Soup block_below() {
  Soup soup = make_box({0.4, 0.4, 0.2});
  for (Vec3& v : soup.vertices) v.z -= 0.1;
  return soup;
}

/// The object goes to and fro along an axis, at up to 1 m/s.
inline void oscillate(ObjectConfig& object, const Vec3& axis_O, double amplitude) {
  object.motion.kind = MotionKind::kOscillate;
  object.motion.axis_O = axis_O;
  object.motion.amplitude = amplitude;
  object.motion.frequency = 1 / (2 * kPi * amplitude);
}

inline MaterialConfig rough(double friction_static, double friction_dynamic) {
  MaterialConfig material;
  material.friction_static = friction_static;
  material.friction_dynamic = friction_dynamic;
  return material;
}

}  // namespace haptic::test
