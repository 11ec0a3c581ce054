// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/polhem/linkage.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptic {
namespace {

constexpr double kLeastSine = 0.02;  // of the angle between rod and tail

/// In the plane that A turns: x outwards, y up.
Vec3 towards(double angle) {
  return {std::cos(angle), std::sin(angle), 0};
}
/// Velocity of towards() per angular velocity.
Vec3 across(double angle) {
  return {-std::sin(angle), std::cos(angle), 0};
}

Vec3 elbow(const PolhemLinkage& g, double b) {
  return Vec3{g.base / 2, 0, 0} + g.upper_arm * towards(b);
}
Vec3 crank_end(const PolhemLinkage& g, double c) {
  return Vec3{-g.base / 2, 0, 0} + g.crank * towards(c);
}

/// Angle in a triangle, between the sides a and b; NaN if they do not reach.
double corner(double a, double b, double opposite) {
  return std::acos((a * a + b * b - opposite * opposite) / (2 * a * b));
}

}  // namespace

double forearm_angle(const PolhemLinkage& g, const Vec3& driven) {
  const Vec3 d = crank_end(g, driven.z) - elbow(g, driven.y);
  const double apart = norm(d);
  const double cosine = (g.tail * g.tail + apart * apart - g.rod * g.rod) / (2 * g.tail * apart);
  return std::atan2(d.y, d.x) - std::numbers::pi - std::acos(std::clamp(cosine, -1.0, 1.0));
}

Vec3 handle_place(const PolhemLinkage& g, const Vec3& driven) {
  const Vec3 end = elbow(g, driven.y) + g.forearm * towards(forearm_angle(g, driven));
  return Vec3{end.x * std::cos(driven.x), end.x * std::sin(driven.x), end.y} - g.origin;
}

Vec3 linkage_moment(const PolhemLinkage& g, const LinkMasses& links, const Vec3& driven) {
  const Vec3 out{std::cos(driven.x), std::sin(driven.x), 0}, left{-out.y, out.x, 0}, up{0, 0, 1};
  const auto moment = [&](const LinkMass& link, const Vec3& from, double angle) {
    const Vec3 along = std::cos(angle) * out + std::sin(angle) * up;
    return link.mass * link_place(from.x * out + from.y * up - g.origin, along, left, link.centre);
  };
  return moment(links[0], {g.base / 2, 0, 0}, driven.y) +
         moment(links[1], elbow(g, driven.y), forearm_angle(g, driven)) +
         moment(links[2], {-g.base / 2, 0, 0}, driven.z);
}

bool solve_linkage(const PolhemLinkage& g, const Vec3& p_B, Vec3& driven) {
  const Vec3 p = p_B + g.origin;
  const Vec3 v{std::hypot(p.x, p.y) - g.base / 2, p.z, 0};
  const double b = std::atan2(v.y, v.x) + corner(g.upper_arm, norm(v), g.forearm);
  const Vec3 forearm = v - g.upper_arm * towards(b);
  const double lambda = std::atan2(forearm.y, forearm.x);
  const Vec3 w = elbow(g, b) - g.tail * towards(lambda) + Vec3{g.base / 2, 0, 0};
  double c = std::atan2(w.y, w.x) + corner(g.crank, norm(w), g.rod);
  if (!std::isfinite(b) || !std::isfinite(c)) return false;
  // the crank hangs behind: from −90° it would jump within the workspace
  if (c < -std::numbers::pi / 2) c += 2 * std::numbers::pi;
  driven = {std::atan2(p.y, p.x), b, c};
  return true;
}

bool linkage_jacobian(const PolhemLinkage& g, const Vec3& driven, Mat3& J) {
  const double lambda = forearm_angle(g, driven);
  const Vec3 rod = elbow(g, driven.y) - g.tail * towards(lambda) - crank_end(g, driven.z);
  // the rod keeps its length: rod · (velocity of the tail's end − that of the crank's) = 0
  const double turning = g.tail * dot(rod, across(lambda));
  if (!(std::fabs(turning) > kLeastSine * g.tail * g.rod)) return false;
  const double by_b = g.upper_arm * dot(rod, across(driven.y)) / turning;
  const double by_c = -g.crank * dot(rod, across(driven.z)) / turning;
  const Vec3 lifted = g.forearm * across(lambda);
  const Vec3 with_b = g.upper_arm * across(driven.y) + by_b * lifted;
  const Vec3 with_c = by_c * lifted;
  const double sin_a = std::sin(driven.x), cos_a = std::cos(driven.x);
  const Vec3 p = handle_place(g, driven) + g.origin;
  J = from_columns({-p.y, p.x, 0}, {with_b.x * cos_a, with_b.x * sin_a, with_b.y},
                   {with_c.x * cos_a, with_c.x * sin_a, with_c.y});
  return true;
}

}  // namespace haptic
