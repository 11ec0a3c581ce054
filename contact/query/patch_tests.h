// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <bit>

#include "contact/shape/patch_tree.h"

namespace haptic {

/// Which points of a patch are asked for: any, those locally nearest to the point, or of these
/// those that have it in front.
enum class Facing { kAny, kEitherSide, kFront };

/// A point made ready for the tests, in float rounded the safe way.
struct PatchProbe {
  using Lanes = PatchNode::Lanes;  // eight times the same
  explicit PatchProbe(const Vec3& p_O);

  Vec3 p_O;
  std::array<Lanes, 3> below, above, at;
  Lanes slack;  // of axis·p
};

/// A sphere on a straight way, made ready for the tests.
struct WayProbe {
  /// `furthest`: largest coordinate of the way and of the mesh.
  WayProbe(const Vec3& from_O, const Vec3& d_O, double radius, double furthest);

  Vec3 from_O;
  std::array<float, 3> from, d;  // in floats
  float length, radius;          // of the way and of the sphere [m]
  float slack;                   // more than the roundings of a distance [m]
};

/// A set of lanes; taken out one by one: for (LaneSet s = …; s.any(); s.pop()) use(s.first()).
class LaneSet {
 public:
  explicit LaneSet(uint32_t bits) : bits_(bits) {}
  bool any() const { return bits_ != 0; }
  size_t first() const { return static_cast<size_t>(std::countr_zero(bits_)); }
  void pop() { bits_ &= bits_ - 1; }
  void remove(size_t lane) { bits_ &= ~(1u << lane); }

 private:
  uint32_t bits_;
};

/// Patches no further than `limit` that may hold a point asked for; distance_squared receives what
/// each of the eight is away at least. Keeps too many, never too few.
LaneSet patches_near(const PatchNode& node, const PatchProbe& probe, float limit, Facing facing,
                     PatchNode::Lanes& distance_squared);

/// Triangles of the leaf that may be no further than `limit`; steps_squared receives how far each
/// is (see distance_at_least). Keeps too many, never too few. Where `nearest` is asked for, limit
/// sinks to what the nearest of them is away at most, and those surely further are left out.
LaneSet triangles_near(const PatchLeaf& leaf, const PatchProbe& probe, bool nearest, float& limit,
                       PatchNode::Lanes& steps_squared);

/// Patches that the sphere may come to touch on its way, and triangles of the leaf: all but those
/// that a plane across some direction keeps off. Keep too many, never too few.
LaneSet patches_on_way(const PatchNode& node, const WayProbe& way);
LaneSet triangles_on_way(const PatchLeaf& leaf, const WayProbe& way);

/// What a triangle is away at least, of what triangles_near said of it.
float distance_at_least(const PatchLeaf& leaf, float steps_squared);

/// The float no less than a distance.
float round_up_distance(double distance);

}  // namespace haptic
