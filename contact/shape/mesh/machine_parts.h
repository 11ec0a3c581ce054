// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "contact/shape/mesh/primitives.h"

namespace haptic {

/// Distance from the z axis at angle θ [rad] and height z, > 0 [m].
using RadiusAt = std::function<double(double theta, double z)>;

/// How finely a part is cut: steps around the axis and along it.
struct PartGrid {
  uint32_t around = 96, along = 16;
};

/// Closed body between two heights whose side is at `outer`: 2·around·(along + 1) triangles.
Soup make_turned(const RadiusAt& outer, double z_lower, double z_upper, const PartGrid& grid);

/// The same with a hole through it, at `inner` < outer.
Soup make_bored(const RadiusAt& outer, const RadiusAt& inner, double z_lower, double z_upper,
                const PartGrid& grid);

/// Peg and the block it goes into, both about the z axis from −length/2 to length/2 [m].
struct PegAndHole {
  double diameter = 20e-3, length = 40e-3;
  double clearance = 0.2e-3;  // between the radii
  double block = 60e-3;       // edge of the square block
};
Soup make_peg(const PegAndHole& pair, const PartGrid& grid);
Soup make_hole(const PegAndHole& pair, const PartGrid& grid);

/// Spur gear about the z axis with a bore; flanks are involutes of the base circle (pressure angle
/// 20°), thinner by `backlash` along the pitch circle; a tooth points along +x.
struct Gear {
  uint32_t teeth = 20;
  double module = 3e-3;      // pitch diameter over teeth [m]
  double width = 10e-3;      // [m]
  double bore = 10e-3;       // diameter [m]
  double backlash = 0.1e-3;  // [m]
};
Soup make_gear(const Gear& gear, const PartGrid& grid);

/// Bolt and nut with one thread, about the z axis; the profile is a rounded trapezoid (a sine cut
/// off at 0.7), so that the gap is `clearance` all along it, measured along the radius. Where the
/// steps of both are equally high and rings of both lie at the same heights, that holds for their
/// triangles too: else chords cut through a gap that is narrower than they are off the curve.
struct BoltAndNut {
  double diameter = 20e-3, pitch = 2.5e-3, depth = 1.4e-3;
  double bolt_length = 40e-3, nut_height = 16e-3, nut_width = 32e-3;
  double clearance = 0.05e-3;
};
Soup make_bolt(const BoltAndNut& pair, const PartGrid& grid);
Soup make_nut(const BoltAndNut& pair, const PartGrid& grid);

}  // namespace haptic
