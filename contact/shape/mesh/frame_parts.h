// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/primitives.h"

namespace haptic {

/// A long part and what it is laid on, a locating pin at each end. The part is a channel of sheet
/// metal that is open below, with a lug at each end; one lug has a round hole, that at −x, the
/// other a slot along x, so that the part is held once in each direction. It carries an upright tab
/// and one to the side, as a frame has for what is fixed to it. The sheet is an eighth of the width
/// thick.
struct FrameParts {
  double length = 180e-3, width = 24e-3, height = 16e-3;  // of the channel with its lugs [m]
  double diameter = 8e-3;                                 // of the pins at their foot [m]
  double clearance = 0.1e-3;                              // between the radii of hole and pin [m]
  double post = 20e-3;                                    // height of the posts under the lugs [m]
  uint32_t around = 48;  // segments of a hole or pin; a multiple of 4
};

/// Height of the tabs [m].
inline double tab_of(const FrameParts& parts) {
  return 2 * parts.width / 3;
}
/// From the middle of the part to each hole [m].
inline double pin_distance(const FrameParts& parts) {
  return 0.5 * (parts.length - parts.width);
}

/// Along x, z up, its middle over the origin, its underside at z = 0.
Soup make_frame_rail(const FrameParts& parts);

/// A base with two posts and their pins, each a cylinder as high as the sheet is thick and half as
/// much again, then a cone to half its radius. The posts end at z = 0: at the identity the rail
/// lies on them.
Soup make_pin_rest(const FrameParts& parts);

/// A plate of this extent [m] about the origin with a rectangular opening through it along z, as
/// wide as `width` along x and as high as `height` along y.
Soup make_window(const Vec3& extent, double width, double height);

}  // namespace haptic
