// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/box/rigid_motion.h"
#include "contact/query/proximity/mesh_distance.h"

namespace haptic {

struct AdvancementOptions {
  double tolerance = 1e-6;  // surfaces nearer than this touch [m]
  uint32_t steps = 1000;    // most distance queries
};

/// How far B can move.
struct Advancement {
  double time = 0;  // the surfaces are apart at this and every earlier time, by at least half the
                    // tolerance or their initial distance
  bool is_hit = false;    // they touch at `time`
  bool is_ended = false;  // cut short by the number of steps or a motion that is not finite;
                          // nothing is known after `time`
  uint32_t steps = 0;
  NearPair nearest;  // at the hit, in A
};

/// First time at which B, moving in A, comes within the tolerance of A, by conservative advancement
/// (Mirtich 1996, with this bound for any mesh): from time t on, no point of B can bridge the
/// distance d before t + d / v, with v = |way| + |θ| r the speed of the fastest point and r the
/// greatest distance of a vertex from the centre. Steps by (d − tolerance/2) / v. Surfaces within
/// the tolerance at the start, meeting or not, are a hit at time 0.
Advancement advance(const MeshShape& shape_A, const MeshShape& shape_B, const RigidMotion& motion,
                    const AdvancementOptions& options = {});

}  // namespace haptic
