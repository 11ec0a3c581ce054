// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "proto/math/units.h"
#include "proto/math/vec3.h"

namespace haptic {

/// Steps that a part's mesh is cut into around its axis and along it.
struct PartGrid {
  uint32_t around = 96, along = 16;
};

/// Generated meshes by their dimensions. Those of two parts that fit each other are in the same
/// axes.
namespace primitive {

/// About the origin.
struct Box {
  Vec3 extent{0.1, 0.1, 0.02};  // [m]
};

/// About the origin, 20·4ⁿ triangles.
struct Sphere {
  double diameter = 0.1;  // [m]
  uint32_t subdivisions = 4;
};

/// About the z axis, from −length/2 to length/2.
struct Peg {
  double diameter = 20e-3, length = 40e-3;  // [m]
  PartGrid grid{96, 16};
};

/// A square block with a through hole for a peg, as long as it.
struct Hole : Peg {
  double clearance = 0.2e-3;  // between the radii [m]
  double block = 60e-3;       // edge of the block [m]
};

/// A spur gear about the z axis with a bore. The flanks are involutes of the base circle (pressure
/// angle 20°), thinned by the backlash; a tooth points along +x.
struct Gear {
  uint32_t teeth = 20;
  double module = 3e-3;      // pitch diameter over teeth [m]
  double width = 10e-3;      // along the axis [m]
  double bore = 10e-3;       // diameter [m]
  double backlash = 0.1e-3;  // along the pitch circle [m]
  PartGrid grid{480, 8};
};

/// One thread about the z axis. Its profile is a rounded trapezoid (a sine clipped at 0.7), so the
/// gap between bolt and nut is the clearance everywhere, measured along the radius. This holds for
/// their triangles, too, if both have steps of the same height and rings at the same heights; else
/// chords would bridge a gap narrower than their sagitta.
struct Thread {
  double diameter = 20e-3;  // over its crests [m]
  double pitch = 2.5e-3, depth = 1.4e-3;
  PartGrid grid{96, 256};
};

struct Bolt : Thread {
  double length = 40e-3;  // [m]
};

/// A hexagon with the thread of the bolt that goes in.
struct Nut : Thread {
  double clearance = 0.05e-3;            // between the radii [m]
  double height = 16e-3, width = 32e-3;  // along the axis; across the flats [m]
};

/// The crown of a right lower first molar, cut at the neck: +x is towards the cheek, +y towards the
/// front teeth, +z up; the origin lies in the middle of the crown, at the height of its cheek-side
/// cusps. 24,552 triangles by default.
struct LowerMolar {
  double width = 11e-3;   // from front to back, all else is in proportion [m]
  uint32_t around = 264;  // steps around the crown, a multiple of 6
};

/// Its antagonist, in the pose in which it bites. Where the two are coarse for the fissures their
/// chords come nearer to each other than the clearance: by default to 0.4 of it, with fewer steps
/// they meet.
struct UpperMolar : LowerMolar {
  double clearance = 0.05e-3;  // along z, between the two [m]
};

/// A ball about the origin with a stem along +z, as of a hip; 43,920 triangles by default. Vertices
/// lie on the sphere and chords within it, by at most d/2·(1 − cos(1.1·2π/around)), 8 µm by
/// default: up to that the gap to its socket is the clearance.
struct JointBall {
  double diameter = 40e-3;  // [m]
  double stem = 16e-3;      // its diameter [m]
  double length = 50e-3;    // from the ball's centre to the end of the stem [m]
  uint32_t around = 240;    // steps around the axis, a multiple of 6
};

/// A cup about the centre of the ball that turns in it, open towards +z; 32,400 triangles by
/// default.
struct JointSocket {
  double diameter = 40e-3;      // of the ball [m]
  double clearance = 0.1e-3;    // between the radii of ball and cavity [m]
  double width = 60e-3;         // outer diameter [m]
  double height = 30e-3;        // below the ball's centre [m]
  double cover = 80 * kDegree;  // of the cavity, from −z [rad]; above π/2 it holds the ball
  uint32_t around = 240;        // steps around the axis, a multiple of 6
};

/// A ball about the origin with 362 dimples, as for golf.
struct DimpledBall {
  double diameter = 42.7e-3;  // between the dimples [m]
  double depth = 0.25e-3;     // of a dimple's middle [m]; 0: a plain ball
  uint32_t along = 82;        // steps along a side of the icosahedron: 20·along² triangles
};

/// The dimensions that a long part and the rest for it have in common.
struct Frame {
  double length = 180e-3, width = 24e-3;  // of the part, with its lugs [m]
  double diameter = 8e-3;                 // of the pins at their foot [m]
  uint32_t around = 48;                   // steps around a hole or pin, a multiple of 4
};

/// A channel of sheet metal along x that is open below, z up, its middle over the origin and its
/// underside at z = 0, with a lug at each end: that at −x has a round hole, the other a slot along
/// x, so that the part is held once in each direction. It carries an upright tab and one to the
/// side, as a frame has for what is fixed to it. The sheet is an eighth of the width thick.
struct FrameRail : Frame {
  double height = 16e-3;      // of the channel [m]
  double clearance = 0.1e-3;  // between the radii of hole and pin [m]
};

/// A base with two posts and their pins, each a cylinder as high as the sheet is thick and half as
/// much again, then a cone to half its radius. The posts end at z = 0: at the identity the part
/// lies on them.
struct PinRest : Frame {
  double height = 20e-3;  // of the posts under the lugs [m]
};

/// A plate about the origin with a rectangular opening along z.
struct Window {
  Vec3 extent{0.1, 0.1, 0.02};           // of the plate [m]
  double width = 60e-3, height = 40e-3;  // of the opening, along x and y [m]
};

}  // namespace primitive

/// A generated mesh; empty: none. Its kinds are the rows of the table.
using Primitive = std::variant<std::monostate
#define PRIMITIVE(Kind, name, make) , primitive::Kind
#include "proto/config/primitives.def"
                               >;
static_assert(std::is_trivially_copyable_v<Primitive>);

/// Each kind's name in a config, and what it is like where nothing else is said.
inline constexpr std::array kPrimitives{
#define PRIMITIVE(Kind, name, make) std::pair{std::string_view(name), Primitive(primitive::Kind{})},
#include "proto/config/primitives.def"
};

/// The name of its kind; there must be one.
constexpr std::string_view kind_name(const Primitive& made) {
  return kPrimitives[made.index() - 1].first;
}

/// True if it is a mesh of one of these kinds.
template <typename... Kinds>
constexpr bool is_any_of(const Primitive& made) {
  return (std::holds_alternative<Kinds>(made) || ...);
}

}  // namespace haptic
