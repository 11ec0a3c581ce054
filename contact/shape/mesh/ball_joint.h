// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/primitives.h"

namespace haptic {

/// A ball with a stem and the socket that it turns in, as of a hip. The ball's centre is the
/// origin of both; the stem goes along +z, the socket opens towards +z.
struct BallJoint {
  double diameter = 40e-3;         // of the ball [m]
  double stem = 16e-3;             // diameter of the stem, less than the ball's [m]
  double length = 50e-3;           // from the ball's centre to the end of the stem [m]
  double clearance = 0.1e-3;       // between the radii of ball and cavity [m]
  double cover = 1.3962634015954;  // of the cavity, from -z [rad]; above π/2 it holds the ball
  double width = 60e-3;            // outer diameter of the socket [m]
  double height = 30e-3;           // of the socket below the ball's centre [m]
  uint32_t around = 240;           // steps around the axis, a multiple of 6
};

/// Solids of revolution, whose steps are all about as long as those around the ball: 43,920 and
/// 32,400 triangles by default. Vertices lie on the sphere and chords within it, by at most
/// d/2·(1 − cos(1.1·2π/around)), 8 µm by default: up to that the gap is `clearance`.
Soup make_joint_ball(const BallJoint& joint);
Soup make_joint_socket(const BallJoint& joint);

}  // namespace haptic
