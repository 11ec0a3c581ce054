// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/scenes/quality_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "clients/lab/support/soups.h"
#include "contact/shape/parts/machine_parts.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr double kDegrees = 180 / kPi;                    // of a radian
constexpr double kTipRadius = 4e-3, kConeHeight = 20e-3;  // [m]
constexpr double kCylinderRadius = 20e-3;                 // [m]
constexpr double kMostOffset = 0.5e-3, kMostTilt = 0.03;  // of the peg [m], [rad]
constexpr double kPegDiameter = 20e-3, kBlock = 50e-3;    // [m]
constexpr double kHoleLength = 60e-3;  // [m]; longer than the peg, whose ends are inside
constexpr size_t kWindow = 21;         // samples of the moving average

/// Radius of the cone at a height above the pole of its tip: a ball, then a cone of 30°.
double cone_radius(double height) {
  const double turn = kTipRadius * (1 - std::sin(kPi / 6));
  if (height < turn) return std::sqrt((2 * kTipRadius - height) * height);
  return kTipRadius * std::cos(kPi / 6) + (height - turn) * std::tan(kPi / 6);
}

/// The pole is a small facet, because a ring needs a radius.
constexpr double kConeFoot = 0.02e-3;  // [m]

Quat turned(const Vec3& axis, double angle) {
  return from_rotation_vector(angle * axis);
}

/// A wrench expressed in the frame whose z axis is the ideal force.
Wrench seen_from(const Quat& q_WI, const Wrench& F_W) {
  return {rotate(conjugate(q_WI), F_W.f), rotate(conjugate(q_WI), F_W.t)};
}

struct Spread {
  double mean = 0, deviation = 0, peak_to_peak = 0;
};

Spread spread_of(const std::vector<Wrench>& wrenches) {
  Spread spread;
  double squares = 0, low = norm(wrenches[0].f), high = low;
  for (const Wrench& F : wrenches) {
    const double f = norm(F.f);
    spread.mean += f, squares += f * f;
    low = std::min(low, f), high = std::max(high, f);
  }
  const double n = static_cast<double>(wrenches.size());
  spread.mean /= n;
  spread.deviation = std::sqrt(std::max(squares / n - spread.mean * spread.mean, 0.0));
  spread.peak_to_peak = high - low;
  return spread;
}

/// RMS of the force minus its moving average over 21 samples, relative to its mean length.
double noise_of(const std::vector<Wrench>& wrenches) {
  if (wrenches.size() < kWindow) return 0;
  double squares = 0, mean = 0;
  const size_t half = kWindow / 2, n = wrenches.size() - 2 * half;
  for (size_t i = half; i < wrenches.size() - half; ++i) {
    Vec3 average;
    for (size_t k = i - half; k <= i + half; ++k) average += wrenches[k].f / double{kWindow};
    squares += norm_squared(wrenches[i].f - average);
    mean += norm(wrenches[i].f) / static_cast<double>(n);
  }
  return mean > 0 ? std::sqrt(squares / static_cast<double>(n)) / mean : 0;
}

/// Angle between a force and +z; 180° for a zero force.
double angle_off(const Vec3& f) {
  return norm(f) > 0 ? kDegrees * std::atan2(std::hypot(f.x, f.y), f.z) : 180;
}

/// A line fitted by least squares.
struct Line {
  double slope = 0, fit = 0;  // fit: R², 0 if there is no variation
};

Line fit_line(const std::vector<double>& x, const std::vector<double>& y) {
  const double n = static_cast<double>(x.size());
  double mx = 0, my = 0, xx = 0, xy = 0, yy = 0;
  for (size_t i = 0; i < x.size(); ++i) mx += x[i] / n, my += y[i] / n;
  for (size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mx) * (x[i] - mx), xy += (x[i] - mx) * (y[i] - my);
    yy += (y[i] - my) * (y[i] - my);
  }
  return {xx > 0 ? xy / xx : 0, xx > 0 && yy > 0 ? xy * xy / (xx * yy) : 0};
}

double share(size_t i, size_t n) {
  return n > 1 ? static_cast<double>(i) / static_cast<double>(n - 1) : 0;
}

void judge_cone(const WrenchAt& wrench_at, size_t n, const QualityGoals& goals, Rows& rows) {
  std::vector<Wrench> felt;
  double direction = 0, tangential = 0;
  for (size_t i = 0; i < n; ++i) {
    // oblique, so that the motion follows no row of voxels
    const Vec3 on_plane = (share(i, n) - 0.5) * Vec3{20e-3, 7.3e-3, 0};
    const Wrench F = wrench_at({on_plane + Vec3{0, 0, 0.5 * kConeHeight - kQualityDepth}, {}});
    felt.push_back(F);
    direction = std::max(direction, angle_off(F.f));
    tangential = std::max(tangential, std::hypot(F.f.x, F.f.y) / std::max(F.f.z, 1e-12));
  }
  const Spread spread = spread_of(felt);
  rows.add({{"force, mean", spread.mean, "N"},
            {"force, std/mean", spread.deviation / spread.mean, "", at_most(goals.cone_spread)},
            {"direction off the normal, max", direction, "deg", at_most(goals.cone_direction)},
            {"tangential/normal force, max", tangential, "", at_most(goals.cone_tangential)},
            {"noise", noise_of(felt)}});
}

void judge_sphere(const WrenchAt& wrench_at, size_t n, const QualityGoals& goals, Rows& rows) {
  std::vector<Wrench> felt;
  double squares = 0, torque = 0;
  for (size_t i = 0; i < n; ++i) {
    const double angle = 2 * kPi * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
    const Quat q_WI = turned({0, 0, 1}, angle) * turned({0, 1, 0}, 0.5 * kPi);
    const Vec3 centre_W =
        (kCylinderRadius + kSphereRadius - kQualityDepth) * rotate(q_WI, {0, 0, 1});
    const Wrench F = seen_from(q_WI, wrench_at({centre_W, {}}));
    felt.push_back(F);
    squares += angle_off(F.f) * angle_off(F.f);
    torque = std::max(torque, norm(F.t) / (std::max(norm(F.f), 1e-12) * kSphereRadius));
  }
  const Spread spread = spread_of(felt);
  rows.add(
      {{"force, mean", spread.mean, "N"},
       {"force, peak to peak/mean", spread.peak_to_peak / spread.mean, "",
        at_most(goals.sphere_spread)},
       {"direction off the radius, rms", std::sqrt(squares / static_cast<double>(n)), "deg",
        at_most(goals.sphere_direction)},
       {"torque about the centre/(force · radius), max", torque, "", at_most(goals.sphere_torque)},
       {"noise", noise_of(felt)}});
}

/// The wrench in the frame that has turned with the cube about the vertical.
Wrench felt_by_cube(const WrenchAt& wrench_at, double yaw, double tilt) {
  const Quat q_WY = turned({0, 0, 1}, yaw);
  // height at which the lowest edge, or the face, is kQualityDepth deep
  const double lowest = kCubeHalf * (std::cos(tilt) + std::sin(std::fabs(tilt)));
  const Pose X_WT{{0, 0, lowest - kQualityDepth}, q_WY * turned({1, 0, 0}, tilt)};
  return seen_from(q_WY, wrench_at(X_WT));
}

void judge_cube(const WrenchAt& wrench_at, size_t n, const QualityGoals& goals, Rows& rows) {
  constexpr double kTilt = 0.02;  // [rad]
  std::vector<Wrench> flat;
  double lean = 0, most = 0, difference = 0;
  for (size_t i = 0; i < n; ++i) {
    const double yaw = 2 * kPi * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
    const Wrench F = felt_by_cube(wrench_at, yaw, 0);
    flat.push_back(F);
    lean = std::max(lean, std::hypot(F.t.x, F.t.y) / (std::max(norm(F.f), 1e-12) * kCubeHalf));
    const Vec3 left = felt_by_cube(wrench_at, yaw, kTilt).t;
    const Vec3 right = felt_by_cube(wrench_at, yaw, -kTilt).t;
    // the mirror y → −y reverses torques about x and z
    difference = std::max(difference, norm(left - Vec3{-right.x, right.y, -right.z}));
    most = std::max({most, norm(left), norm(right)});
  }
  const Spread spread = spread_of(flat);
  rows.add(
      {{"force, mean", spread.mean, "N"},
       {"force, std/mean", spread.deviation / spread.mean},
       {"flat: torque about x, y/(force · half edge), max", lean, "", at_most(goals.cube_torque)},
       {"tilted: torque, max", most, "N·m"},
       {"tilted: mirrored torques differ by, of the largest", most > 0 ? difference / most : 1, "",
        at_most(goals.cube_mirror)},
       {"noise", noise_of(flat)}});
}

void judge_offset_peg(const WrenchAt& wrench_at, size_t n, const QualityGoals& goals, Rows& rows) {
  std::vector<double> beyond, force;
  std::vector<Wrench> felt;
  double off = 0;
  for (size_t i = 0; i < n; ++i) {
    const double e = kPegClearance + (kMostOffset - kPegClearance) * (0.05 + 0.95 * share(i, n));
    // in a direction that follows no row of voxels
    const Quat q_WI = turned({0, 0, 1}, 0.4) * turned({0, 1, 0}, -0.5 * kPi);
    const Wrench F = seen_from(q_WI, wrench_at({rotate(q_WI, {0, 0, -e}), {}}));
    felt.push_back(F);
    beyond.push_back(e - kPegClearance), force.push_back(norm(F.f));
    off = std::max(off, angle_off(F.f));
  }
  const Line line = fit_line(beyond, force);
  rows.add({{"aside: stiffness", line.slope, "N/m"},
            {"aside: R² of force over e − c", line.fit, "", at_least(goals.peg_fit)},
            {"aside: direction off the wall's normal, max", off, "deg"},
            {"aside: noise", noise_of(felt)}});
}

void judge_tilted_peg(const WrenchAt& wrench_at, size_t n, Rows& rows) {
  std::vector<double> beyond, couple;
  size_t wrong = 0;
  double net = 0;
  const double free_tilt = kPegClearance / kPegHalf;
  for (size_t i = 0; i < n; ++i) {
    const double tilt = free_tilt + (kMostTilt - free_tilt) * (0.1 + 0.9 * share(i, n));
    const double sign = i % 2 == 0 ? 1 : -1;
    const Wrench F = wrench_at({{}, turned({1, 0, 0}, sign * tilt)});
    const double back = -sign * F.t.x;
    wrong += !(back > 0);
    beyond.push_back(kPegHalf * (tilt - free_tilt)), couple.push_back(back);
    // a pure couple has no net force
    net = std::max(net, norm(F.f) * kPegHalf / std::max(norm(F.t), 1e-12));
  }
  const Line line = fit_line(beyond, couple);
  rows.add({{"tilted: places where the couple does not turn back", static_cast<double>(wrong), "",
             at_most(0)},
            {"tilted: couple over what the ends overlap", line.slope, "N"},
            {"tilted: R² of it", line.fit},
            {"tilted: net force · half length/couple, max", net}});
}

void judge_peg(const WrenchAt& wrench_at, size_t n, const QualityGoals& goals, Rows& rows) {
  const double centred = norm(wrench_at({}).f);
  rows.add("centred: force", centred, "N", at_most(0));
  double pushing_in = 0;
  for (size_t i = 0; i < n; ++i) {
    const double height = (1 - share(i, n)) * 0.5 * (kHoleLength + 2 * kPegHalf);
    const Vec3 place{0.5 * kPegClearance, 0, height};
    pushing_in = std::max(pushing_in, norm(wrench_at({place, {}}).f));
  }
  rows.add("pushed in, half the clearance aside: force, max", pushing_in, "N", at_most(0));
  judge_offset_peg(wrench_at, n, goals, rows);
  judge_tilted_peg(wrench_at, n, rows);
}

}  // namespace

std::string_view name_of(QualityScene scene) {
  constexpr std::array kNames{"cone on plane", "sphere round cylinder", "cube on plate",
                              "peg in hole"};
  return kNames[static_cast<size_t>(scene)];
}

double spacing_of(QualityScene scene, const QualityGrain& grain) {
  return scene == QualityScene::kSphereRoundCylinder ? 0.25 * grain.spacing : grain.spacing;
}

QualityBodies bodies_of(QualityScene scene, const QualityGrain& grain) {
  const uint32_t around = 64 * grain.fineness;
  const Soup plate = lowered(make_box({60e-3, 60e-3, 10e-3}), 5e-3);
  switch (scene) {
    case QualityScene::kConeOnPlane: {
      const double half = 0.5 * kConeHeight;
      const auto radius = [&](double, double z) { return cone_radius(z + half); };
      return {plate, make_turned(radius, kConeFoot - half, half, {around, around})};
    }
    case QualityScene::kSphereRoundCylinder: {
      const auto radius = [](double, double) { return kCylinderRadius; };
      return {make_turned(radius, -20e-3, 20e-3, {around, around / 4}),
              make_icosphere(kSphereRadius, 3 + grain.fineness / 2)};
    }
    case QualityScene::kCubeOnPlate:
      return {plate, make_box({2 * kCubeHalf, 2 * kCubeHalf, 2 * kCubeHalf})};
    case QualityScene::kPegInHole:
      break;
  }
  const PartGrid grid{around, 16};
  return {make_hole({{kPegDiameter, kHoleLength, grid}, kPegClearance, kBlock}),
          make_peg({kPegDiameter, 2 * kPegHalf, grid})};
}

void judge_quality(QualityScene scene, const WrenchAt& wrench_at, size_t samples,
                   const QualityGoals& goals, const std::string& case_name, const Rows& all) {
  Rows rows = all.of(case_name, goals.are_judged);
  constexpr std::array kJudges{judge_cone, judge_sphere, judge_cube, judge_peg};
  kJudges[static_cast<size_t>(scene)](wrench_at, samples, goals, rows);
}

}  // namespace haptic
