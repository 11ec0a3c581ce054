// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "contact/shape/volume/distance_field.h"
#include "contact/shape/volume/pointshell.h"
#include "proto/math/pose.h"

namespace haptic {

/// What is known of a shell and a field from queries before. What the field says at a point changes
/// by no more than the point travels, times a constant: so a node stays free, a point is no nearer,
/// and the nearest of a patch no further than that. Sized once, for one shell.
struct ShellCoherence {
  std::vector<double> free_until;  // wear at which a node of the shell is to be asked again;
                                   // negative: until which it is asked in vain [m]
  std::vector<double> low;         // of each point: its distance is at least low − slack [m]
  std::vector<double> high;        // of each patch: its nearest is at most high + slack [m]
  double slack = 0;                // what distances may have changed since the first query [m]
  double wear = 0;                // travel of the point that went furthest, and growth of reach [m]
  Pose X_OT;                      // of the last query
  double reach = 0;               // of the last query [m]
  bool is_fresh = true;           // nothing is known
  std::array<Vec3, 8> corners_T;  // of the box around the shell

  explicit ShellCoherence(const Pointshell& shell);
  void forget() { is_fresh = true; }
};

/// Notes the way from the last query to this one. Begins anew where it is fresh, and after 1000 m.
void note_travel(const Pose& X_OT, double reach, ShellCoherence& coherence);

/// How far a point goes at least before the field there says `reach`, and any point that is so far
/// from it. Negative: nothing is known.
double way_to(double reach, const FieldDistance& at, double cell);

/// Once the slack has grown by s the field says no less there than this less s, as far as anything
/// within the band is concerned.
double low_end(const DistanceField& field, const FieldDistance& at);

/// How far the shell may travel until what has this low end may be within reach.
double travel_until(double low, double reach, const ShellCoherence& coherence);

}  // namespace haptic
