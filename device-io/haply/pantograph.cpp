// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/haply/pantograph.h"

#include <cmath>

namespace haptic {
namespace {

/// Sine of the least angle between the distal links: closer to one line, a torque would be fifty
/// times that of the middle of the workspace.
constexpr double kLeastSine = 0.02;

Vec3 motor(const PantographGeometry& g, int i) {
  return {i == 0 ? -g.base / 2 : g.base / 2, 0, 0};
}

Vec3 elbow(const PantographGeometry& g, const PantographAngles& angles, int i) {
  const double theta = angles[static_cast<size_t>(i)];
  return motor(g, i) + g.proximal * Vec3{std::cos(theta), std::sin(theta), 0};
}

/// Turned by 90° to the left.
Vec3 left_of(const Vec3& a) {
  return {-a.y, a.x, 0};
}

}  // namespace

bool find_pantograph_handle(const PantographGeometry& g, const PantographAngles& angles,
                            Vec3& p_B) {
  const Vec3 a = elbow(g, angles, 0);
  const Vec3 across = elbow(g, angles, 1) - a;
  const double apart = norm(across);
  // with φ between a distal link and the elbows' line: cos φ = apart/2L, and 2φ is the angle
  // between the distal links up to a half turn
  const double cosine = apart / (2 * g.distal);
  const double height2 = 1 - cosine * cosine;
  if (!(height2 > 0) || !(2 * cosine * std::sqrt(height2) > kLeastSine)) return false;
  p_B = a + across / 2 + g.distal * std::sqrt(height2) / apart * left_of(across);
  return true;
}

Vec3 pantograph_moment(const PantographGeometry& g, const LinkMasses& links,
                       const PantographAngles& angles, const Vec3& p_B) {
  Vec3 sum;
  for (int i = 0; i < 2; ++i) {
    const Vec3 from = motor(g, i), end = elbow(g, angles, i);
    const auto moment = [&](const LinkMass& link, const Vec3& at, const Vec3& to) {
      const Vec3 along = normalized(to - at), left = left_of(along);
      const Vec3 place =
          link_place(at, along, i == 0 ? left : -left, {link.centre.x, link.centre.y, 0});
      return link.mass * (place + Vec3{0, 0, link.centre.z});
    };
    sum += moment(links[0], from, end) + moment(links[1], end, p_B);
  }
  return sum;
}

bool pantograph_jacobian(const PantographGeometry& g, const PantographAngles& angles,
                         const Vec3& p_B, std::array<Vec3, 2>& J) {
  const std::array<Vec3, 2> u{p_B - elbow(g, angles, 0), p_B - elbow(g, angles, 1)};
  const double area = u[0].x * u[1].y - u[0].y * u[1].x;
  if (!(std::fabs(area) > kLeastSine * g.distal * g.distal)) return false;
  for (int i = 0; i < 2; ++i) {
    // the handle turns about the other elbow
    const Vec3& own = u[static_cast<size_t>(i)];
    const Vec3 way = left_of(u[static_cast<size_t>(1 - i)]);
    const Vec3 t = left_of(elbow(g, angles, i) - motor(g, i));
    J[static_cast<size_t>(i)] = dot(own, t) / dot(own, way) * way;
  }
  return true;
}

}  // namespace haptic
