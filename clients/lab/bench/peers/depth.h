// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "contact/shape/convex/hull.h"
#include "proto/math/pose.h"

namespace haptic {

/// Another library's query on two convex hulls, b at X_AB.
struct HullPeer {
  std::string name;
  std::function<double(const Pose& X_AB)> answer;  // [m]; negative if it finds nothing
};

/// Penetration depth, those that are installed: Bullet's GJK–EPA in its double build first, then
/// libccd's GJK–EPA and FCL's convex shapes (libccd's MPR). The hulls must outlive them.
std::vector<HullPeer> depth_peers(const Hull& a, const Hull& b);

/// Distance: FCL's convex shapes (libccd's GJK).
std::vector<HullPeer> distance_peers(const Hull& a, const Hull& b);

}  // namespace haptic
