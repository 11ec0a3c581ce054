// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/kinematics.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kClosed = 1e-12;      // agreement of the angles: 1e-13 m at the handle [rad]
constexpr double kLongestStep = 0.02;  // of Newton's method [m]; the workspace is 0.1 m wide
constexpr int kMostSteps = 20;         // from the origin ten reach any corner
constexpr double kFlatLeg = 1e-6;      // of a·L sin(knee) [m²]; in the workspace it is above 1e-3
constexpr double kSingular = 100;      // of det J [rad³/m³]; in the workspace it is above 1000

bool solve_leg(const FalconGeometry& g, size_t i, const Vec3& p, double& angle, Vec3& row) {
  const double a = g.upper_arm, b = g.parallelogram;
  const double cos_phi = std::cos(g.azimuth[i]), sin_phi = std::sin(g.azimuth[i]);
  const double u = p.x * cos_phi + p.y * sin_phi - g.motor_radius + g.plate_radius;
  const double v = -p.x * sin_phi + p.y * cos_phi - g.motor_shift + g.plate_shift;
  const double w = p.z + g.origin_z;
  if (!(v * v < b * b)) return false;
  const double q = std::sqrt(b * b - v * v);
  const double L = g.knee + g.ankle + q;
  const double rho = std::hypot(u, w);
  const double cos_shoulder = (rho * rho + a * a - L * L) / (2 * a * rho);
  if (!(std::fabs(cos_shoulder) < 1)) return false;
  angle = std::atan2(w, u) - std::acos(cos_shoulder);

  // the constraint, differentiated
  const double U = u - a * std::cos(angle), W = w - a * std::sin(angle);
  const double by_angle = a * (U * std::sin(angle) - W * std::cos(angle));
  if (!(std::fabs(by_angle) > kFlatLeg)) return false;
  const double du = -U / by_angle, dv = -L * v / (q * by_angle), dw = -W / by_angle;
  row = {cos_phi * du - sin_phi * dv, sin_phi * du + cos_phi * dv, dw};
  return true;
}

}  // namespace

bool solve_falcon(const FalconGeometry& g, const Vec3& p_B, FalconPose& pose) noexcept {
  for (size_t i = 0; i < 3; ++i) {
    const int leg = static_cast<int>(i);
    if (!solve_leg(g, i, p_B, pose.angles[leg], pose.J.row[leg])) return false;
  }
  return true;
}

Vec3 falcon_moment(const FalconGeometry& g, const LinkMasses& links, const Vec3& p_B) noexcept {
  Vec3 sum;
  FalconPose pose;
  if (!solve_falcon(g, p_B, pose)) return sum;
  for (size_t i = 0; i < 3; ++i) {
    const double theta = pose.angles[static_cast<int>(i)];
    const Vec3 out{std::cos(g.azimuth[i]), std::sin(g.azimuth[i]), 0}, left{-out.y, out.x, 0};
    const Vec3 axis{0, 0, 1};
    const Vec3 motor = g.motor_radius * out + g.motor_shift * left - g.origin_z * axis;
    const Vec3 arm = std::cos(theta) * out + std::sin(theta) * axis;
    const Vec3 knee = motor + g.upper_arm * arm;
    const Vec3 plate = p_B + g.plate_radius * out + g.plate_shift * left;
    // the rods begin and end where the leg's own offsets have led, in its plane
    const double across = dot(plate - knee, left);
    const Vec3 in_plane = normalized(plate - knee - across * left);
    const Vec3 rod = normalized(plate - knee - (g.knee + g.ankle) * in_plane);
    const Vec3 beside = normalized(cross(cross(in_plane, left), rod));
    sum += links[0].mass * link_place(motor, arm, left, links[0].centre) +
           links[1].mass * link_place(knee + g.knee * in_plane, rod, beside, links[1].centre);
  }
  return sum;
}

bool find_falcon_handle(const FalconGeometry& g, const Vec3& angles, Vec3& p_B) noexcept {
  Vec3 p = p_B;
  FalconPose pose;
  for (int n = 0; n < kMostSteps; ++n) {
    if (!solve_falcon(g, p, pose)) return false;
    const Vec3 error = angles - pose.angles;
    if (std::max({std::fabs(error.x), std::fabs(error.y), std::fabs(error.z)}) < kClosed) {
      p_B = p;
      return true;
    }
    Vec3 step;
    if (!solve_rows(pose.J.row[0], pose.J.row[1], pose.J.row[2], error, kSingular, step)) {
      return false;
    }
    const double length = norm(step);
    p += (length > kLongestStep ? kLongestStep / length : 1.0) * step;
  }
  return false;
}

bool falcon_jacobian(const FalconPose& pose, HandleJacobian& J) noexcept {
  const Vec3(&by_place)[3] = pose.J.row;
  for (int i = 0; i < 3; ++i) {
    Vec3 unit;
    unit[i] = 1;
    Vec3& column = J[static_cast<size_t>(i)].v;
    if (!solve_rows(by_place[0], by_place[1], by_place[2], unit, kSingular, column)) return false;
  }
  return true;
}

}  // namespace haptic
