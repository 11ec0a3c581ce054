// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/detect/point/point_scene.h"

namespace haptic {

/// The nearest surface of one object, which a penalty force pushes towards.
struct NearestSurface {
  ProxyPlane facet;
  ProxySupport at;   // its normal outward
  double depth = 0;  // of the tool behind the surface, negative in front [m]
};

/// For each object that contains p_W or is nearer than reach [m]: its closest point, and the
/// outward direction. Stateless. Deepest first; returns their number. Beside the rim of an open
/// surface nothing is behind it.
size_t nearest_surfaces(const PointScene& scene, const Vec3& p_W, double reach,
                        std::span<NearestSurface> out);

}  // namespace haptic
