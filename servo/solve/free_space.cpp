// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/free_space.h"

#include <algorithm>

namespace haptic {

FreeSpace::FreeSpace(const ContactSet& set, const RigidBody& tool,
                     const std::array<Pose, kMaxObjects>& X_WO)
    : set_(set),
      X_WO_(X_WO),
      X_WGC_(motion_of_centre(tool, {set.X_WG, {}}).X_WC),
      radius_(tool.radius) {}

double FreeSpace::left_at(const Pose& X_WC) const {
  if (!(set_.clearance > 0)) return 0;
  double most = 0;
  for (uint32_t i = 0; i < std::min(set_.n_objects, kMaxObjects); ++i) {
    const Pose then = inverse(set_.X_WO[i]) * X_WGC_, now = inverse(X_WO_[i]) * X_WC;
    const double length = length_of(way_between(then, now));
    if (!(length < set_.clearance)) return set_.clearance - length;
    most = std::max(most, length);
  }
  return set_.clearance - most;
}

std::optional<Pose> FreeSpace::nearest_to(const Pose& X_WC, const Pose& otherwise) const {
  const double left = left_at(X_WGC_);
  if (!(left > 0)) return std::nullopt;
  const Twist way = way_between(X_WGC_, X_WC);
  const double beyond = length_of(way) - left;
  if (!(beyond < length_of(way_between(otherwise, X_WC)))) return std::nullopt;
  return moved(X_WGC_, limit_travel(way, radius_, left).motion);
}

}  // namespace haptic
