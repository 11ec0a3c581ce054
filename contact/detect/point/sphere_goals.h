// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "contact/detect/point/point_scene.h"
#include "proto/math/project_point.h"

namespace haptic {

/// The planes met in one leg, offset by epsilon.
struct ProxyLeg {
  static constexpr size_t kMaxPlanes = 12;     // beyond, those that do not push are dropped
  static constexpr double kNoProgress = 1e-3;  // of epsilon: shorter moves are no progress

  std::array<HalfSpace, kMaxPlanes> half_spaces;
  std::array<ProxyPlane, kMaxPlanes> planes;
  size_t size = 0;

  std::span<const HalfSpace> view() const { return {half_spaces.data(), size}; }
  bool holds(const ProxyPlane& plane) const {
    const auto known = std::span(planes).first(size);
    return std::find(known.begin(), known.end(), plane) != known.end();
  }
};

/// Subgoal at an edge or vertex: its tangent plane turns while a sphere rolls around it, so the
/// nearest point on the plane is only a small part of the way. The line from the feature through
/// the tool meets the plane where the motion towards the tool ends at the place of rest. Where the
/// tool is beside or behind the feature the sphere rolls on by a least step. The given subgoal if
/// there is no such bend.
Vec3 beyond_bend(const PointScene& scene, const ProxyPlane& plane, const HalfSpace& tangent,
                 const Vec3& g_W, const Vec3& p_W, const Vec3& subgoal_W);

/// A goal beyond the place of rest in a crease of two obstacles or a corner of three, at least one
/// of them round: on the line from the tool through that place, as far out as the tangent planes
/// require. In a corner the sphere touches only two at a time: the third may be one of the previous
/// leg.
Vec3 beyond_crease(const PointScene& scene, const ProxyLeg& pushing, const ProxyLeg& before,
                   const Vec3& g_W, const Vec3& tool_W, const Vec3& subgoal_W);

}  // namespace haptic
