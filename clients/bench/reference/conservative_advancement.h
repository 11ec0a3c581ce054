// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/box/rigid_motion.h"
#include "contact/query/proximity/mesh_distance.h"

namespace haptic {

struct AdvancementOptions {
  double tolerance = 1e-6;  // apart by less counts as touching [m]
  uint32_t steps = 1000;    // distances asked at most
};

/// How far B gets.
struct Advancement {
  double time = 0;        // at this time and any before the surfaces are apart, by half the
                          // tolerance or what they were at first
  bool is_hit = false;    // at `time` they are nearer than the tolerance
  bool is_ended = false;  // the number of steps did, or a motion that is not finite: may go on
  uint32_t steps = 0;
  NearPair nearest;  // of the hit, in A
};

/// First time at which B, moving in A, comes within the tolerance of A: from a time t on no point
/// of B can bridge the distance d before t + d / v, v = |way| + |θ| r the speed of the fastest
/// point, r the greatest distance of a vertex from the centre (conservative advancement; Mirtich
/// 1996, with this bound for any mesh). Goes on in steps of (d − tolerance/2) / v. Where they are
/// within the tolerance at first, meeting or not, that is a hit at time 0.
Advancement advance(const MeshShape& shape_A, const MeshShape& shape_B, const RigidMotion& motion,
                    const AdvancementOptions& options = {});

}  // namespace haptic
