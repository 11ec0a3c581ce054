// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "proto/config/config_names.h"
#include "proto/math/vec3.h"

namespace haptic {

enum class JointKind : uint32_t {
#define JOINT(id, name, path, ...) id,
#include "proto/config/joints.def"
};

/// The freedoms that a kind of joint leaves. One that slides or twists has a coordinate, on which
/// limits, spring, damper, friction and detents act.
struct JointKindRow {
  JointKind id{};
  std::string_view name;
  bool slides = false;      // along its axis
  bool twists = false;      // about its axis
  bool swings = false;      // about every axis
  bool has_points = false;  // its axis is a curve through these, and turns nothing

  constexpr bool has_coordinate() const { return slides || twists; }
  constexpr bool has_axis() const { return has_coordinate() && !has_points; }
  /// Its coordinate is an angle.
  constexpr bool turns() const { return twists && !slides; }
  /// Its coordinate alone says where the body is.
  constexpr bool is_led() const { return slides != twists; }
};

inline constexpr std::array kJointKinds{
#define JOINT(kind, word, path, ...) \
  JointKindRow{.id = JointKind::kind, .name = word __VA_OPT__(, ) __VA_ARGS__},
#include "proto/config/joints.def"
};

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
