// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/detect/point/point_proxy.h"

namespace haptic {

/// The nearest surface of one object: towards it a penalty force pushes.
struct NearestSurface {
  uint32_t object = 0;
  uint32_t triangle = 0;
  Feature feature;
  Vec3 point_O;
  Vec3 normal_O;     // unit, outward
  double depth = 0;  // of the tool behind it, negative in front [m]
};

/// For each object behind whose surface p_W is, or that is nearer than reach: its closest point and
/// the direction from the tool outward. Stateless. Deepest first; returns how many. The rim of an
/// open surface has no behind.
size_t nearest_surfaces(const PointScene& scene, const Vec3& p_W, double reach,
                        std::span<NearestSurface> out);

}  // namespace haptic
