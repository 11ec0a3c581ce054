// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "proto/config/scene/joint_config.h"
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

/// Where A is at a position of a hinge, slider or curve.
Pose pose_on(const Joint& joint, const Pose& X_WB, double position);

/// What spring and detents do along the coordinate, and how it changes with the position.
struct JointLoad {
  double load = 0;   // [N·m] or [N]
  double slope = 0;  // [N·m/rad] or [N/m]
};
/// Beyond the table the detents' load is that of its end.
JointLoad load_at(const Joint& joint, double position);

/// How a body moves by the speed that a step ends with.
enum class Moves {
  kByMean,  // by the mean of the speeds before and after
  kByEnd    // by the speed after it
};

/// Change of a speed by the load of a joint within dt. Spring and detents are linearised at their
/// position. Of what moves by the mean they act at the middle of the way, which keeps energy and is
/// stable for any stiffness; of what moves by the end they act where they are (keeps energy too),
/// or at the end of the way where they are too stiff for that. The damper acts by the speed at the
/// end and never turns it round. `mobility`: change of the speed per impulse; `load`: what else
/// acts along the coordinate.
double speed_change(const Joint& joint, double position, double speed, double mobility, double load,
                    double dt, Moves moves);

}  // namespace haptic
