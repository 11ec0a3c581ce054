// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for proto/math: Vec3, Mat3, Quat, Pose, Wrench.
#include <random>

#include "proto/math/units.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

Vec3 random_vec(std::mt19937_64& rng) {
  std::normal_distribution<double> gauss;
  return {gauss(rng), gauss(rng), gauss(rng)};
}
Pose random_pose(std::mt19937_64& rng) {
  return {random_vec(rng), from_rotation_vector(random_vec(rng))};
}
}  // namespace

TEST_CASE("math: cross product is antisymmetric to the last bit", "[math]") {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a = random_vec(rng), b = random_vec(rng);
    CHECK(cross(a, b) == -cross(b, a));
  }
}

TEST_CASE("math: a quarter turn about z takes x to y", "[math]") {
  const Quat q = from_rotation_vector({0, 0, kPi / 2});
  CHECK_THAT(rotate(q, {1, 0, 0}), IsNear({0, 1, 0}, kAlgebra));
  CHECK_THAT((to_matrix(q) * Vec3{1, 0, 0}), IsNear({0, 1, 0}, kAlgebra));
}

TEST_CASE("math: rotation vector round trip takes the shorter arc", "[math]") {
  std::mt19937_64 rng(2);
  for (int i = 0; i < 1000; ++i) {
    const double angle = kPi * (i + 0.5) / 1001;
    const Vec3 r = angle * normalized(random_vec(rng));
    const Quat q = from_rotation_vector(r);
    CHECK_THAT(to_rotation_vector(q), IsNear(r, 1e-10));
    CHECK_THAT(to_rotation_vector(Quat{-q.x, -q.y, -q.z, -q.w}), IsNear(r, 1e-10));
  }
  const Vec3 tiny{1e-12, -2e-12, 3e-13};
  CHECK_THAT(to_rotation_vector(from_rotation_vector(tiny)), IsNear(tiny, 1e-24));
}

TEST_CASE("math: slerp across the double cover does not go the long way", "[math]") {
  const Quat a = from_rotation_vector({0, 0, 0.2});
  const Quat b = from_rotation_vector({0, 0, 0.6});
  const Quat minus_b{-b.x, -b.y, -b.z, -b.w};
  CHECK_THAT(to_rotation_vector(slerp(a, minus_b, 0.5)), IsNear({0, 0, 0.4}, kAlgebra));
}

TEST_CASE("math: poses form a group and act on points", "[math]") {
  std::mt19937_64 rng(3);
  for (int i = 0; i < 200; ++i) {
    const Pose X_AB = random_pose(rng), X_BC = random_pose(rng);
    const Vec3 p_C = random_vec(rng);
    CHECK_THAT((X_AB * X_BC) * p_C, IsNear(X_AB * (X_BC * p_C), 1e-11));
    CHECK_THAT(inverse(X_AB) * (X_AB * p_C), IsNear(p_C, 1e-11));
  }
}

TEST_CASE("math: extrapolation by a twist matches the velocity of a point", "[math]") {
  std::mt19937_64 rng(4);
  const Pose X = random_pose(rng);
  const Twist V{random_vec(rng), random_vec(rng)};
  const Vec3 p_B = random_vec(rng);
  const double h = 1e-6;
  const Vec3 numeric = ((extrapolate(X, V, h) * p_B) - (extrapolate(X, V, -h) * p_B)) / (2 * h);
  CHECK_THAT(velocity_at(V, X * p_B - X.p), IsNear(numeric, 1e-8));
}

TEST_CASE("math: a shifted wrench does the same work on any twist", "[math]") {
  std::mt19937_64 rng(5);
  const Wrench F{random_vec(rng), random_vec(rng)};
  const Twist V{random_vec(rng), random_vec(rng)};
  const Vec3 r = random_vec(rng);  // from the new reference point to the old one
  const Wrench G = shift(F, r);
  const double power_old = dot(F.f, velocity_at(V, r)) + dot(F.t, V.w);
  const double power_new = dot(G.f, V.v) + dot(G.t, V.w);
  CHECK(std::fabs(power_old - power_new) <= tol(1e-11));
}
