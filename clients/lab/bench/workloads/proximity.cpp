// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/workloads/proximity.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "clients/lab/bench/workloads/workload.h"
#include "clients/lab/support/dice.h"
#include "clients/lab/support/soups.h"
#include "contact/query/proximity/mesh_distance.h"
#include "contact/shape/parts/machine_parts.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

Quat about_x(double angle) {
  return from_rotation_vector({angle, 0, 0});
}
Quat about_y(double angle) {
  return from_rotation_vector({0, angle, 0});
}
Quat about_z(double angle) {
  return from_rotation_vector({0, 0, angle});
}

/// Radii 30 and 8 mm with bumps of 0.4 mm.
Soup bumpy_torus(uint32_t around, uint32_t across) {
  return make_closed_grid(around, across, [&](uint32_t i, uint32_t j) {
    const double a = 2 * kPi * i / around, b = 2 * kPi * j / across;
    const double tube = 8 + 0.4 * std::sin(9 * a) * std::cos(5 * b);
    const double r = 30 + tube * std::cos(b);
    return kMm * Vec3{r * std::cos(a), r * std::sin(a), tube * std::sin(b)};
  });
}

/// Thread of 1.5 mm depth and 2.5 mm pitch on a core of this radius [mm].
RadiusAt thread_on(double core) {
  return [core](double theta, double z) {
    const double turns = z / kMm / 2.5 - theta / (2 * kPi);
    const double saw = std::fabs(2 * (turns - std::floor(turns)) - 1);
    const double s = std::clamp((saw - 0.25) / 0.5, 0.0, 1.0);
    return kMm * (core + 1.5 * s * s * (3 - 2 * s));
  };
}

/// A threaded bore in a round outer side, both with the same angles, their rims joined.
Soup nut() {
  constexpr uint32_t kAround = 96, kInner = 160, kOuter = 40;
  constexpr double kHalf = 10 * kMm;
  Soup soup;
  const auto add_rings = [&](const RadiusAt& radius, uint32_t along) {
    const auto first = static_cast<uint32_t>(soup.vertices.size());
    for (uint32_t k = 0; k <= along; ++k) {
      const double z = kHalf * (2.0 * k / along - 1);
      for (uint32_t i = 0; i < kAround; ++i) {
        const double theta = 2 * kPi * i / kAround, r = radius(theta, z);
        soup.vertices.push_back({r * std::cos(theta), r * std::sin(theta), z});
      }
    }
    return first;
  };
  const uint32_t inner = add_rings(thread_on(8.9), kInner);
  const uint32_t outer = add_rings([](double, double) { return 18 * kMm; }, kOuter);
  const auto add_quad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    soup.triangles.push_back({a, b, c});
    soup.triangles.push_back({a, c, d});
  };
  const auto at = [](uint32_t first, uint32_t k, uint32_t i) {
    return first + k * kAround + i % kAround;
  };
  for (uint32_t i = 0; i < kAround; ++i) {
    for (uint32_t k = 0; k < kInner; ++k) {
      add_quad(at(inner, k, i), at(inner, k + 1, i), at(inner, k + 1, i + 1), at(inner, k, i + 1));
    }
    for (uint32_t k = 0; k < kOuter; ++k) {
      add_quad(at(outer, k, i), at(outer, k, i + 1), at(outer, k + 1, i + 1), at(outer, k + 1, i));
    }
    add_quad(at(inner, 0, i), at(inner, 0, i + 1), at(outer, 0, i + 1), at(outer, 0, i));
    add_quad(at(inner, kInner, i), at(outer, kOuter, i), at(outer, kOuter, i + 1),
             at(inner, kInner, i + 1));
  }
  return soup;
}

Pose torus_pose(double t, double apart) {
  const Quat q = about_x(swing(0.25, 0.8, t)) * about_z(swing(0.2, 0.6, t)) * about_x(kPi / 2) *
                 about_z(0.7 * t);
  const Vec3 p{apart + swing(0.5, 1.7, t), swing(3, 0.9, t), swing(3, 0.5, t)};
  return {kMm * p, normalized(q)};
}

Pose bolt_pose(double t) {
  const double turn = 2 * kPi * 0.5 * t;
  const Quat q = about_x(swing(0.004, 1.1, t)) * about_y(swing(0.004, 0.7, t)) * about_z(turn);
  const Vec3 p{swing(0.12, 2.3, t), 0.12 * std::cos(2 * kPi * 1.9 * t),
               2.5 * turn / (2 * kPi) - 5 + swing(0.03, 5, t)};
  return {kMm * p, normalized(q)};
}

template <class PoseAt>
std::vector<Pose> followed(size_t n, const PoseAt& pose_at) {
  std::vector<Pose> poses;
  for (size_t i = 0; i < n; ++i) poses.push_back(pose_at(kTick * static_cast<double>(i)));
  return poses;
}

}  // namespace

ProximityWork torus_on_torus(size_t poses) {
  return {"torus on torus", build_shape(bumpy_torus(200, 100)), build_shape(bumpy_torus(164, 82)),
          followed(poses, [](double t) { return torus_pose(t, 43.6); })};
}

ProximityWork bolt_through_nut(size_t poses) {
  const Soup bolt = make_turned(thread_on(8.5), -20 * kMm, 20 * kMm, {96, 140});
  return {"bolt in nut", build_shape(nut()), build_shape(bolt), followed(poses, bolt_pose)};
}

std::vector<RigidMotion> torus_motions(const ProximityWork& tori, size_t n) {
  Dice dice(5);
  const auto uniform = [&](double low, double high) { return dice.uniform(low, high); };
  std::vector<RigidMotion> motions;
  while (motions.size() < n) {
    const Pose from = torus_pose(uniform(0, 2), 43.2);
    const double apart = mesh_distance(tori.object.view(), tori.tool.view(), from).at_least;
    if (apart < 0.05 * kMm || apart > 2 * kMm) continue;
    const Quat turn = from_rotation_vector(uniform(0.1, 2) * kPi / 180 * direction_in_ball(dice));
    const Vec3 way =
        kMm * (uniform(-0.3, 1.2) * Vec3{1, 0, 0} + uniform(0, 0.4) * direction_in_ball(dice));
    motions.push_back(motion_between(from, {from.p + way, normalized(turn * from.q)}, {}));
  }
  return motions;
}

}  // namespace haptic
