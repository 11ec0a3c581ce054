// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/free_space.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic {

FreeSpace::FreeSpace(const ContactSet& set, const ToolBody& tool, const TickScene& scene)
    : set_(set), scene_(scene), tool_(tool), X_WGC_(motion_of_centre(tool, {set.X_WG, {}}).X_WC) {}

double FreeSpace::left_to_planes(const Pose& X_WC) const {
  double left = std::numeric_limits<double>::infinity();
  if (scene_.surfaces.empty()) return left;
  const Pose X_WT = tool_of_centre(tool_, X_WC);
  for (const Contact& c : set_.contacts) {
    if (c.giver == 0) continue;
    const Pose X_WO = scene_.pose_of(scene_.body_of(c));
    const Vec3 way_W = X_WT * c.tool_point_T - X_WO * c.object_point_O;
    const double off = dot(rotate(X_WO.q, c.normal_O), way_W);
    // past its extent, where it has faded, it stops nothing
    constexpr double kFaded = 1.1;
    const double along = std::sqrt(std::max(norm_squared(way_W) - off * off, 0.0));
    const double beside = c.extent > 0 ? along - kFaded * c.extent : off;
    left = std::min(left, std::max(off, beside));
  }
  return left;
}

double FreeSpace::left_at(const Pose& X_WC) const {
  const auto& seen = set_.objects;
  if (seen.empty() || seen.size() > scene_.n_objects()) return 0;
  double left = left_to_planes(X_WC);
  for (size_t i = 0; i < seen.size(); ++i) {
    if (!(seen[i].clearance > 0)) return 0;
    const Pose then = inverse(seen[i].X_WO) * X_WGC_, now = inverse(scene_.X_WO[i]) * X_WC;
    const double of_this = seen[i].clearance - largest_travel(way_between(then, now), tool_.radius);
    if (!(of_this > 0)) return of_this;  // NaN too
    left = std::min(left, of_this);
  }
  return left;
}

std::optional<Pose> FreeSpace::nearest_to(const Pose& X_WC, const Pose& otherwise) const {
  const double left = left_at(X_WGC_);
  if (!(left > 0)) return std::nullopt;
  const Twist way = way_between(X_WGC_, X_WC);
  const double beyond = largest_travel(way, tool_.radius) - left;
  if (!(beyond < largest_travel(way_between(otherwise, X_WC), tool_.radius))) return std::nullopt;
  return moved(X_WGC_, limit_travel(way, tool_.radius, left).motion);
}

}  // namespace haptic
