// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/motion/motion.h"

namespace haptic {

/// Stays at the configured pose.
extern const Motion still_motion{
    [](const ObjectConfig& object, double, double) {
      return ScriptedState{object.X_WO, {}};
    },
    [](const ObjectConfig&, const Pose&, const Twist&) { return 0.0; }};

}  // namespace haptic
