// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "contact/shape/volume/distance_field.h"
#include "contact/shape/volume/pointshell.h"
#include "proto/math/pose.h"

namespace haptic {

/// Temporal coherence of a shell in a field (McNeely, Puterbaugh, Troy 2006). The field at a point
/// changes by at most a constant times the travel of the point (Lipschitz bound); this bounds how
/// long a node stays farther than the reach, a point no nearer than its lower bound, and the
/// nearest point of a patch no farther than its upper bound. Sized once, for one shell.
struct ShellCoherence {
  std::vector<double> free_until;  // accumulated travel at which a node must be tested again;
                                   // negative: known near until −free_until [m]
  std::vector<double> low;         // per point: its distance is at least low − slack [m]
  std::vector<double> high;        // per patch: its nearest point is at most high + slack away [m]
  double slack = 0;                // bound of the change of any distance since the first query [m]
  double wear = 0;   // accumulated travel of the farthest-moving point, plus increases of reach [m]
  Pose X_OT;         // of the last query
  double reach = 0;  // of the last query [m]
  bool is_fresh = true;           // no bounds yet
  std::array<Vec3, 8> corners_T;  // bounding box of the shell

  explicit ShellCoherence(const Pointshell& shell);
  void forget() { is_fresh = true; }
};

/// Accumulates the motion since the last query. Resets the bounds if the coherence is fresh, or
/// after 1000 m.
void note_travel(const Pose& X_OT, double reach, ShellCoherence& coherence);

/// Travel of a point, at least, before the field there can read less than `reach`; a point at this
/// distance from it is farther than `reach`, too. Negative: unknown.
double way_to(double reach, const FieldDistance& at, double cell);

/// Lower bound d of the field along the motion of a point: after the slack has grown by s, the
/// field reads at least d − s there, or more than the band.
double low_end(const DistanceField& field, const FieldDistance& at);

/// Travel before a point with this lower bound can come within reach.
double travel_until(double low, double reach, const ShellCoherence& coherence);

}  // namespace haptic
