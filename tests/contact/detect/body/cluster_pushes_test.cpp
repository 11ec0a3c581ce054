// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/cluster_pushes.h"

#include <array>
#include <vector>

#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

std::vector<PointPush> flat_patch(size_t n, double half, double depth, double k) {
  Random random(1);
  std::vector<PointPush> pushes;
  for (size_t i = 0; i < n; ++i) {
    pushes.push_back(
        {{random.uniform(-half, half), random.uniform(-half, half), 0}, {0, 0, 1}, depth, k});
  }
  return pushes;
}

Wrench wrench_of(std::span<const PushCluster> clusters) {
  Wrench sum;
  for (const PushCluster& c : clusters) {
    const Vec3 f = (c.stiffness * std::max(c.depth, 0.0)) * c.normal_O;
    sum = sum + Wrench{f, cross(c.point_O, f)};
  }
  return sum;
}

}  // namespace

TEST_CASE("clusters: the sum of the forces stays, and the torque of what is flat", "[contact]") {
  const auto pushes = flat_patch(200, 0.02, 1e-3, 50);
  std::array<PushCluster, 16> clusters;
  const size_t n = cluster_pushes(pushes, {8e-3, 0.5}, clusters);
  CHECK(n > 4);
  const LinearPush all = sum_pushes(pushes, {});
  const Wrench few = wrench_of({clusters.data(), n});
  CHECK_THAT(few.f, IsNear(all.F0_O.f, 1e-4));
  CHECK_THAT(few.t, IsNear(all.F0_O.t, 1e-6));
}

TEST_CASE("clusters: opposite normals do not cancel", "[contact][trap]") {
  // a peg in a slot: two walls push against each other, closer together than the radius
  std::vector<PointPush> pushes;
  for (int i = 0; i < 20; ++i) {
    pushes.push_back({{1e-3, 1e-4 * i, 0}, {1, 0, 0}, 1e-4, 100});
    pushes.push_back({{-1e-3, 1e-4 * i, 0}, {-1, 0, 0}, 1e-4, 100});
  }
  std::array<PushCluster, 16> clusters;
  const size_t n = cluster_pushes(pushes, {5e-3, 0.5}, clusters);
  REQUIRE(n == 2);
  CHECK(std::fabs(dot(clusters[0].normal_O, clusters[1].normal_O) + 1) < 1e-9);
  CHECK(clusters[0].depth == Approx(1e-4).epsilon(1e-3));
  // the linearisation resists across the slot with both walls
  CHECK(sum_pushes(pushes, {}).K(0, 0) == Approx(-4000));
  CHECK(norm(sum_pushes(pushes, {}).F0_O.f) < 1e-12);
}

TEST_CASE("clusters: points that approach have clusters of their own", "[contact]") {
  auto pushes = flat_patch(10, 1e-3, 1e-3, 50);
  for (PointPush& p : flat_patch(10, 1e-3, -2e-4, 50)) pushes.push_back(p);
  pushes.back().depth = -1e-4;
  std::array<PushCluster, 16> clusters;
  const size_t n = cluster_pushes(pushes, {5e-3, 0.5}, clusters);
  REQUIRE(n == 2);
  CHECK(clusters[0].depth == Approx(1e-3).epsilon(1e-5));
  CHECK(clusters[1].depth == -1e-4);
  CHECK(clusters[1].count == 10);
}

TEST_CASE("clusters: with no more room each point goes where it fits best", "[contact]") {
  const auto pushes = flat_patch(300, 0.05, 1e-3, 10);
  std::array<PushCluster, 4> clusters;
  const size_t n = cluster_pushes(pushes, {1e-3, 0.5}, clusters);
  REQUIRE(n == 4);
  uint32_t count = 0;
  for (const PushCluster& c : clusters) count += c.count;
  CHECK(count == 300);
  CHECK_THAT(wrench_of(clusters).f, IsNear(sum_pushes(pushes, {}).F0_O.f, 1e-4));
  CHECK(cluster_pushes({}, {}, clusters) == 0);
}

TEST_CASE("clusters: the linearised wrench against asking again", "[contact][trap]") {
  // springs whose points move with the tool: F(δ) − F0 − K δ is of second order
  Random random(7);
  std::vector<PointPush> pushes;
  for (int i = 0; i < 40; ++i) {
    pushes.push_back(
        {0.03 * random.direction(), random.direction(), random.uniform(1e-3, 2e-3), 100});
  }
  const LinearPush linear = sum_pushes(pushes, {});
  for (int k = 0; k < 50; ++k) {
    const Twist motion{1e-5 * random.direction(), 1e-4 * random.direction()};
    auto moved_pushes = pushes;
    for (PointPush& p : moved_pushes) {
      p.depth -= dot(p.normal_O, motion.v + cross(motion.w, p.point_O));
    }
    const Wrench again = sum_pushes(moved_pushes, {}).F0_O, change = linear.K * motion;
    REQUIRE_THAT(again.f, IsNear(linear.F0_O.f + change.f, 1e-12));
    REQUIRE_THAT(again.t, IsNear(linear.F0_O.t + change.t, 1e-12));
  }
}

TEST_CASE("clusters: what pushes never goes without for what approaches", "[contact][trap]") {
  std::vector<PointPush> pushes = flat_patch(200, 0.05, -1e-4, 10);
  for (const PointPush& p : flat_patch(3, 0.001, 1e-3, 10)) pushes.push_back(p);
  std::array<PushCluster, 8> clusters;
  const size_t n = cluster_pushes(pushes, {2e-3, 0.5}, clusters);
  REQUIRE(n == 8);
  CHECK(clusters[0].depth > 0);
  CHECK_THAT(wrench_of({clusters.data(), n}).f, IsNear({0, 0, 3 * 10 * 1e-3}, 1e-6));
}
