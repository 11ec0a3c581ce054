// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/free_space.h"

#include <algorithm>
#include <limits>

namespace haptic {

FreeSpace::FreeSpace(const ContactSet& set, const ToolBody& tool, std::span<const Pose> X_WO)
    : set_(set),
      X_WO_(X_WO),
      X_WGC_(motion_of_centre(tool, {set.X_WG, {}}).X_WC),
      radius_(tool.radius) {}

double FreeSpace::left_at(const Pose& X_WC) const {
  const auto& seen = set_.objects;
  if (seen.empty() || seen.size() > X_WO_.size()) return 0;
  double left = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < seen.size(); ++i) {
    if (!(seen[i].clearance > 0)) return 0;
    const Pose then = inverse(seen[i].X_WO) * X_WGC_, now = inverse(X_WO_[i]) * X_WC;
    const double of_this = seen[i].clearance - largest_travel(way_between(then, now), radius_);
    if (!(of_this > 0)) return of_this;  // NaN too
    left = std::min(left, of_this);
  }
  return left;
}

std::optional<Pose> FreeSpace::nearest_to(const Pose& X_WC, const Pose& otherwise) const {
  const double left = left_at(X_WGC_);
  if (!(left > 0)) return std::nullopt;
  const Twist way = way_between(X_WGC_, X_WC);
  const double beyond = largest_travel(way, radius_) - left;
  if (!(beyond < largest_travel(way_between(otherwise, X_WC), radius_))) return std::nullopt;
  return moved(X_WGC_, limit_travel(way, radius_, left).motion);
}

}  // namespace haptic
