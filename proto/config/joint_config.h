// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "proto/config/config_names.h"
#include "proto/math/vec3.h"

namespace haptic {

enum class JointKind : uint32_t { kHinge, kSlider, kCylinder, kBall, kFixed, kCurve };

struct JointKindRow {
  std::string_view name;
  JointKind id;
  bool has_axis = false;
  bool has_coordinate = false;  // limits, spring, damper, friction and detents act on it
  bool turns = false;           // its coordinate is an angle
};

inline constexpr std::array<JointKindRow, 6> kJointKinds{{
    {.name = "hinge",
     .id = JointKind::kHinge,
     .has_axis = true,
     .has_coordinate = true,
     .turns = true},
    {.name = "slider", .id = JointKind::kSlider, .has_axis = true, .has_coordinate = true},
    {.name = "cylinder", .id = JointKind::kCylinder, .has_axis = true, .has_coordinate = true},
    {.name = "ball", .id = JointKind::kBall},
    {.name = "fixed", .id = JointKind::kFixed},
    {.name = "curve", .id = JointKind::kCurve, .has_coordinate = true},
}};

constexpr const JointKindRow& row_of(JointKind kind) {
  return kJointKinds[static_cast<size_t>(kind)];
}

/// A point of the table of detents.
struct DetentPoint {
  double position = 0;  // of the joint [rad] or [m]
  double load = 0;      // along its coordinate [N·m] or [N]
};

inline constexpr uint32_t kToWorld = 1000;        // no object has that index
inline constexpr double kNoStop = 1e12;           // [rad] or [m]: as far as any number of a session
inline constexpr uint32_t kMostDetents = 48;      // limits the size of SessionConfig
inline constexpr uint32_t kMostCurvePoints = 24;  // likewise

constexpr bool is_stop(double end) {
  return -kNoStop < end && end < kNoStop;
}

/// A mechanism between an object with mass and another one or the world. Its coordinate is zero
/// where the session begins: the angle about `axis` of a hinge, the way along it of a slider and of
/// a cylinder, that along the curve.
struct JointConfig {
  Name name{};
  JointKind kind{};
  uint32_t object = 0;     // index
  uint32_t to = kToWorld;  // index
  Vec3 at_W;  // at the start: a point of the axis, the middle of the ball, the object on its curve
  Vec3 axis_W{0, 0, 1};     // of unit length, at the start
  double lower = -kNoStop;  // end stops, ≤ 0 ≤ [rad] or [m]
  double upper = kNoStop;
  double stiffness = 0;  // [N·m/rad] or [N/m]
  double rest = 0;       // of that spring [rad] or [m]
  double damping = 0;    // [N·m·s/rad] or [N·s/m]
  double friction = 0;   // dry: [N·m] or [N]
  uint32_t n_detents = 0;
  uint32_t n_points = 0;
  std::array<DetentPoint, kMostDetents> detents{};  // ascending
  // of a curve: where the object's origin goes from where it is at the start
  std::array<Vec3, kMostCurvePoints> points_W{};
};

}  // namespace haptic
