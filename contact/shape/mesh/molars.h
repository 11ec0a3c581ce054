// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/primitives.h"

namespace haptic {

/// The crowns of a right lower first molar and of its antagonist, cut at the neck, in the pose in
/// which they bite: +x is towards the cheek, +y towards the front teeth, +z up; the origin lies in
/// the middle of the lower crown, at the height of its cheek-side cusps.
///
/// Both chewing surfaces follow one surface z = h(x, y), the mean of the smooth upper envelope of
/// cones under the lower cusps and the smooth lower envelope of cones over the upper ones, with
/// wrinkles: fissures are where cones meet, and a cusp lies in the pit of the other tooth. Towards
/// its rim each crown retreats from h. The lower one is nowhere above h, the upper one nowhere
/// below h + clearance, so they touch over most of the surface that they share.
struct Molars {
  double width = 11e-3;        // of the lower crown along y, all else is in proportion [m]
  double clearance = 0.05e-3;  // along z, between the two [m]
  uint32_t around = 264;       // steps around a crown, a multiple of 6
};

/// 24,552 triangles each by default. Where they are coarse for the fissures the chords of the two
/// come nearer to each other than `clearance`: by default to 0.4 of it, with fewer steps they meet.
Soup make_lower_molar(const Molars& molars);
Soup make_upper_molar(const Molars& molars);

}  // namespace haptic
