// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/bench_pair_workload.h"

#include <cmath>
#include <numbers>
#include <random>

#include "contact/query/triangle_pairs.h"

namespace haptic {
namespace {

constexpr double kPi = std::numbers::pi;

Quat about(const Vec3& axis, double angle) {
  return from_rotation_vector(angle * axis);
}

}  // namespace

Soup make_bumpy_torus(uint32_t around, uint32_t across) {
  constexpr double kRadius = 30e-3, kTube = 8e-3, kBump = 0.4e-3;
  Soup soup;
  for (uint32_t i = 0; i < around; ++i) {
    for (uint32_t j = 0; j < across; ++j) {
      const double a = 2 * kPi * i / around, b = 2 * kPi * j / across;
      const double tube = kTube + kBump * std::sin(9 * a) * std::cos(5 * b);
      const double out = kRadius + tube * std::cos(b);
      soup.vertices.push_back({out * std::cos(a), out * std::sin(a), tube * std::sin(b)});
      const uint32_t next_i = (i + 1) % around, next_j = (j + 1) % across;
      const uint32_t v00 = i * across + j, v10 = next_i * across + j, v01 = i * across + next_j,
                     v11 = next_i * across + next_j;
      soup.triangles.push_back({v00, v10, v11});
      soup.triangles.push_back({v00, v11, v01});
    }
  }
  return soup;
}

Pose linked_tori(double t) {
  const auto wave = [t](double hertz) { return std::sin(2 * kPi * hertz * t); };
  const Quat q = about({1, 0, 0}, 0.25 * wave(0.8)) * about({0, 0, 1}, 0.2 * wave(0.6)) *
                 about({1, 0, 0}, kPi / 2) * about({0, 0, 1}, 0.7 * t);
  return {{43.2e-3 + 0.5e-3 * wave(1.7), 3e-3 * wave(0.9), 3e-3 * wave(0.5)}, normalized(q)};
}

std::vector<RigidMotion> torus_motions(const MeshShape& object, const MeshShape& tool, size_t n) {
  std::mt19937_64 engine(5);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  const auto direction = [&] {
    for (;;) {
      const Vec3 v{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
      if (norm_squared(v) > 1e-4 && norm_squared(v) < 1) return normalized(v);
    }
  };
  std::vector<RigidMotion> motions;
  while (motions.size() < n) {
    const Pose from = linked_tori(uniform(0, 2));
    if (triangle_pairs(object, tool, from, {}) > 0) continue;
    const Vec3 way = Vec3{uniform(-0.3e-3, 1.2e-3), 0, 0} + uniform(0, 0.4e-3) * direction();
    const Quat turn = about(direction(), uniform(0.1, 2) * kPi / 180);
    motions.push_back(motion_between(from, {from.p + way, normalized(turn * from.q)}, {}));
  }
  return motions;
}

}  // namespace haptic
