// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "proto/config/joint_config.h"
#include "proto/math/pose.h"
#include "proto/math/spatial.h"
#include "sim/joint/curve.h"
#include "sim/joint/spline.h"

namespace haptic {

/// A mechanism between two bodies A and B, or A and the world; constant after start. C is the frame
/// of a body's centre of mass, J that of the joint, whose z is the axis; without B its poses are
/// those of W.
struct Joint {
  JointConfig config;
  Pose X_AJ, X_BJ;  // of J in the two frames C
  Spline detents;   // load by position; empty: none
  Curve curve;      // in J of B
};

/// The axis of a joint where its bodies are.
struct JointAxis {
  std::array<Vec3, 3> axes_W;  // the third is the axis
  Vec3 anchor_W;               // of B
  Vec3 curvature_W;            // of the way of the anchor [1/m]
  double position = 0;         // of A along it [m]
};

/// The shape of a joint's axis, of each kind in proto/config/joints.def.
struct JointPath {
  /// The axis for A and B at these poses of J. `near`: position a little while ago.
  JointAxis (*axis)(const Joint& joint, const Pose& X_WJa, const Pose& X_WJb, double near);
  /// The point at a position, in J of B.
  CurvePoint (*at)(const Joint& joint, double position);
};

/// At the start the two bodies have these poses.
Joint build_joint(const JointConfig& config, const Pose& X_WA, const Pose& X_WB);

/// row_a · V_a + row_b · V_b of the twists of the centres of mass in W: a speed of A relative to B.
struct JointRow {
  Twist a, b;
  double error = 0;  // what has been left open of it [m] or [rad]
};

/// A joint where its bodies are.
struct JointRows {
  std::array<JointRow, 6> locks;  // speeds that it lets be zero only
  uint32_t n_locks = 0;
  JointRow along;       // the speed of its coordinate
  double position = 0;  // of its coordinate; of a ball the angle turned
  Vec3 anchor_W;        // of B
  Vec3 axis_W;          // of the coordinate
  Vec3 curvature_W;     // of the way of the anchor [1/m]
};

/// `near`: position a little while ago; a hinge that has turned more than once goes on from there.
JointRows joint_rows(const Joint& joint, const Pose& X_WA, const Pose& X_WB, double near);

/// Where A is at a position of a joint that its coordinate leads.
Pose pose_on(const Joint& joint, const Pose& X_WB, double position);

/// The direction in W in which a joint that slides goes from a position on.
Vec3 direction_on(const Joint& joint, const Pose& X_WB, double position);

/// What spring and detents do along the coordinate, and how it changes with the position.
struct JointLoad {
  double load = 0;   // [N·m] or [N]
  double slope = 0;  // [N·m/rad] or [N/m]
};
/// Beyond the table the detents' load is that of its end.
JointLoad load_at(const Joint& joint, double position);

/// A step of a joint's coordinate.
struct CoordinateStep {
  double dt = 0;                   // [s]
  double position = 0, speed = 0;  // at its beginning
  double mobility = 0;             // w: change of the speed per impulse
  double pushed_speed = 0;  // u: what pushes add to the mean speed beyond the speed at the end
};

/// Speed at the end of a step of what moves by the mean of the speeds before and after, Δq = dt (v
/// + v′)/2, under the mean load over that way (the averaged vector field: Quispel and McLaren,
/// 2008):
///   v′ = v + dt w [ ∫ F(q + s Δq) ds − c (v′ + u) ],  s from 0 to 1.
/// The load's work is the change of its potential, so energy neither grows nor shrinks but by the
/// damper, whatever step and stiffness. The damper acts by the way of the step that the pushes of
/// the hand have made of it: nothing at rest, and it never turns a speed round. `load` gives the
/// JointLoad at a position; solved by Newton's method, at most kMostIterations times.
template <class Load>
double speed_by_mean_load(const CoordinateStep& step, double damping, const Load& load) {
  constexpr int kMostIterations = 12;   // 2 or 3 for what oscillates with ω dt < 1
  constexpr double kConverged = 1e-13;  // of the speed
  // Gauss's three points: exact for a cubic, as each piece of a table is
  constexpr double kAside = 0.38729833462074169;  // √15 / 10
  constexpr std::array<std::pair<double, double>, 3> kPoints{
      {{0.5 - kAside, 5.0 / 18}, {0.5, 8.0 / 18}, {0.5 + kAside, 5.0 / 18}}};
  const double dt = step.dt, drag = dt * step.mobility * damping;
  double next = step.speed;
  for (int i = 0; i < kMostIterations; ++i) {
    const double way = 0.5 * dt * (step.speed + next);
    JointLoad mean;
    for (const auto& [s, weight] : kPoints) {
      const JointLoad at = load(step.position + s * way);
      mean.load += weight * at.load;
      mean.slope += weight * s * at.slope;
    }
    const double open =
        next - step.speed - dt * step.mobility * mean.load + drag * (next + step.pushed_speed);
    // a load that pushes away faster than a step can follow is walked along in shorter ways
    const double slope =
        std::max(1 + drag - 0.5 * dt * dt * step.mobility * mean.slope, 0.5 * (1 + drag));
    next -= open / slope;
    if (std::fabs(open) <= kConverged * std::max(std::fabs(step.speed), std::fabs(next))) break;
  }
  return next;
}

/// Speed at the end of a step of what moves by that speed, Δq = dt v′, under the load where it is
/// (keeps energy in the mean), or at the end of the way where a spring is too stiff for that. The
/// damper as above. `load`: what else acts along the coordinate.
double speed_by_end(const Joint& joint, const CoordinateStep& step, double load);

}  // namespace haptic
