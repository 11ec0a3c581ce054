// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "proto/math/vec3.h"

/// Random numbers of the workloads: equal seeds give equal ones.
namespace haptic {

/// splitmix64 (Steele, Lea, Flood 2014): the same numbers with every standard library.
class SplitMix {
 public:
  explicit SplitMix(uint64_t seed) : state_(seed) {}
  uint64_t next() {
    uint64_t z = (state_ += 0x9E3779B97F4A7C15);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
    return z ^ (z >> 31);
  }
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double uniform(double a, double b) { return a + (b - a) * uniform(); }

 private:
  uint64_t state_;
};

/// Mersenne twister with the distributions of the standard library.
class Dice {
 public:
  explicit Dice(uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  /// A direction uniform on the sphere: a normal distribution along each axis, normalised.
  Vec3 direction() {
    std::normal_distribution<double> normal;
    return normalized(Vec3{normal(engine_), normal(engine_), normal(engine_)});
  }

 private:
  std::mt19937_64 engine_;
};

/// A direction uniform on the sphere by rejection from a ball, from the uniform numbers of any of
/// the generators above.
Vec3 direction_in_ball(auto& random) {
  for (;;) {
    const Vec3 v{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    if (norm_squared(v) > 1e-4 && norm_squared(v) <= 1) return normalized(v);
  }
}

}  // namespace haptic
