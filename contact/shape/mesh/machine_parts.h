// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "contact/shape/mesh/primitives.h"

namespace haptic {

/// Distance from the z axis [m], > 0, at angle θ [rad] and height z [m].
using RadiusAt = std::function<double(double theta, double z)>;

/// Resolution of a part: steps around the axis and along it.
struct PartGrid {
  uint32_t around = 96, along = 16;
};

/// Closed solid between two heights with its side at `outer`: 2·around·(along + 1) triangles.
Soup make_turned(const RadiusAt& outer, double z_lower, double z_upper, const PartGrid& grid);

/// A turned solid with a through hole of radius `inner` < outer.
Soup make_bored(const RadiusAt& outer, const RadiusAt& inner, double z_lower, double z_upper,
                const PartGrid& grid);

/// A peg and the block with its hole, both about the z axis from −length/2 to length/2 [m].
struct PegAndHole {
  double diameter = 20e-3, length = 40e-3;
  double clearance = 0.2e-3;  // difference of the radii
  double block = 60e-3;       // edge of the square block
};
Soup make_peg(const PegAndHole& pair, const PartGrid& grid);
Soup make_hole(const PegAndHole& pair, const PartGrid& grid);

/// Spur gear about the z axis with a bore; the flanks are involutes of the base circle (pressure
/// angle 20°), thinned by `backlash` along the pitch circle; a tooth points along +x.
struct Gear {
  uint32_t teeth = 20;
  double module = 3e-3;      // pitch diameter / number of teeth [m]
  double width = 10e-3;      // [m]
  double bore = 10e-3;       // diameter [m]
  double backlash = 0.1e-3;  // [m]
};
Soup make_gear(const Gear& gear, const PartGrid& grid);

/// Bolt and nut with matching threads, about the z axis; the profile is a rounded trapezoid (a sine
/// clipped at 0.7), so the gap is `clearance` everywhere, measured along the radius. This holds for
/// their triangles, too, if both have steps of the same height and rings at the same heights; else
/// chords would bridge a gap narrower than their sagitta.
struct BoltAndNut {
  double diameter = 20e-3, pitch = 2.5e-3, depth = 1.4e-3;
  double bolt_length = 40e-3, nut_height = 16e-3, nut_width = 32e-3;
  double clearance = 0.05e-3;
};
Soup make_bolt(const BoltAndNut& pair, const PartGrid& grid);
Soup make_nut(const BoltAndNut& pair, const PartGrid& grid);

}  // namespace haptic
