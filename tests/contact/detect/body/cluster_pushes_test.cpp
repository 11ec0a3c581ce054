// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/cluster_pushes.h"

#include <algorithm>
#include <array>
#include <numbers>
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

/// Without a frame before.
size_t clustered(std::span<const PointPush> pushes, const ClusterOptions& options,
                 std::span<PushCluster> clusters) {
  ClusterMemory memory;
  return cluster_pushes(pushes, options, memory, clusters);
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
  const size_t n = clustered(pushes, {8e-3, 0.5}, clusters);
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
  const size_t n = clustered(pushes, {5e-3, 0.5}, clusters);
  REQUIRE(n == 2);
  CHECK(std::fabs(dot(clusters[0].normal_O, clusters[1].normal_O) + 1) < 1e-9);
  CHECK(clusters[0].depth == Approx(1e-4).epsilon(1e-3));
  // the linearisation resists across the slot with both walls
  CHECK(sum_pushes(pushes, {}).K(0, 0) == Approx(-4000));
  CHECK(norm(sum_pushes(pushes, {}).F0_O.f) < 1e-12);
}

TEST_CASE("clusters: of tens of thousands of points none pushes another way than its own",
          "[contact][trap]") {
  // both walls of a slot, far wider than the clusters that there is room for, one wall pressed more
  std::vector<PointPush> pushes;
  for (const double side : {1.0, -1.0}) {
    for (PointPush p : flat_patch(20'000, 0.1, side > 0 ? 2e-3 : 1e-3, 5)) {
      p.point_O.z = -0.2e-3 * side;
      p.normal_O = {0, 0, side};
      pushes.push_back(p);
    }
  }
  std::array<PushCluster, kMostClusters> clusters;
  const size_t n = clustered(pushes, {1e-3, 0.5}, clusters);
  double up = 0, down = 0;
  double count = 0;
  for (size_t i = 0; i < n; ++i) {
    const double force = clusters[i].stiffness * clusters[i].depth * clusters[i].normal_O.z;
    (force > 0 ? up : down) += force;
    CHECK(std::fabs(clusters[i].normal_O.z) > 1 - 1e-9);
    count += clusters[i].count;
  }
  CHECK(count == static_cast<double>(pushes.size()));
  CHECK(up == Approx(20'000 * 5 * 2e-3));
  CHECK(down == Approx(-20'000 * 5 * 1e-3));
}

TEST_CASE("clusters: points that approach have clusters of their own", "[contact]") {
  auto pushes = flat_patch(10, 1e-3, 1e-3, 50);
  for (PointPush& p : flat_patch(10, 1e-3, -2e-4, 50)) pushes.push_back(p);
  pushes.back().depth = -1e-4;
  std::array<PushCluster, 16> clusters;
  const size_t n = clustered(pushes, {5e-3, 0.5}, clusters);
  REQUIRE(n == 2);
  CHECK(clusters[0].depth == Approx(1e-3).epsilon(1e-5));
  CHECK(clusters[1].depth == -1e-4);
  CHECK(clusters[1].count == 10);
}

TEST_CASE("clusters: with no more room each point goes where it fits best", "[contact]") {
  const auto pushes = flat_patch(300, 0.05, 1e-3, 10);
  std::array<PushCluster, 4> clusters;
  const size_t n = clustered(pushes, {1e-3, 0.5}, clusters);
  REQUIRE(n == 4);
  double count = 0;
  for (const PushCluster& c : clusters) count += c.count;
  CHECK(count == 300);
  CHECK_THAT(wrench_of(clusters).f, IsNear(sum_pushes(pushes, {}).F0_O.f, 1e-4));
  CHECK(clustered({}, {}, clusters) == 0);
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
  const size_t n = clustered(pushes, {2e-3, 0.5}, clusters);
  REQUIRE(n == 8);
  CHECK(clusters[0].depth > 0);
  CHECK_THAT(wrench_of({clusters.data(), n}).f, IsNear({0, 0, 3 * 10 * 1e-3}, 1e-6));
}

TEST_CASE("clusters: stiffness of 4 to 400 contacts within a factor of 1.5", "[contact][trap]") {
  const double k = 1000;
  double least = 1e9, most = 0;
  for (const size_t n : {4u, 6u, 10u, 25u, 50u, 100u, 200u, 400u}) {
    const auto force_at = [&](double depth) {
      auto pushes = flat_patch(n, 0.02, depth, 0);
      share_stiffness(pushes, k, 4);
      std::array<PushCluster, 16> clusters;
      return wrench_of({clusters.data(), clustered(pushes, {}, clusters)}).f.z;
    };
    const double slope = (force_at(1.1e-3) - force_at(0.9e-3)) / 0.2e-3;
    least = std::min(least, slope), most = std::max(most, slope);
  }
  CAPTURE(least, most);
  CHECK(most <= 1.5 * least);
  CHECK(most == Approx(4 * k).epsilon(1e-4));
  // found as they just touch, they share it as well: the next tick is deeper
  auto touching = flat_patch(400, 0.02, 0, 0);
  share_stiffness(touching, k, 4);
  CHECK(touching[0].stiffness == Approx(k / 100).epsilon(1e-6));
}

TEST_CASE("clusters: a stool of three feet, tilted", "[contact][trap]") {
  // a cluster for each foot of 25 points; the torque that turns it back
  std::vector<PointPush> pushes;
  const double tilt = 0.02;
  for (int foot = 0; foot < 3; ++foot) {
    const double at = 2 * std::numbers::pi / 3 * foot;
    for (int i = 0; i < 25; ++i) {
      const Vec3 p{0.05 * std::cos(at) + 1e-3 * (i % 5), 0.05 * std::sin(at) + 1e-3 * (i / 5), 0};
      pushes.push_back({p, {0, 0, 1}, 2e-3 + tilt * p.x, 40});
    }
  }
  std::array<PushCluster, 16> clusters;
  const size_t n = clustered(pushes, {8e-3, 0.5}, clusters);
  REQUIRE(n == 3);
  const Wrench few = wrench_of({clusters.data(), n}), all = sum_pushes(pushes, {}).F0_O;
  CHECK(norm(all.t) > 1e-3);
  CHECK(norm(few.t - all.t) <= 0.05 * norm(all.t));
  CHECK_THAT(few.f, IsNear(all.f, 1e-5));
  // tilted further as three springs, against all of them
  const Twist turn{{}, {0, -1e-3, 0}};
  for (PointPush& p : pushes) p.depth -= dot(p.normal_O, cross(turn.w, p.point_O));
  for (PushCluster& c : clusters) c.depth -= dot(c.normal_O, cross(turn.w, c.point_O));
  const Vec3 torque = sum_pushes(pushes, {}).F0_O.t - all.t,
             of_feet = wrench_of({clusters.data(), n}).t - few.t;
  CHECK(norm(of_feet - torque) <= 0.05 * norm(torque));
}

TEST_CASE("clusters: the order of the points does not matter", "[contact][trap]") {
  Random random(11);
  std::vector<PointPush> pushes;
  for (int i = 0; i < 300; ++i) {
    const Vec3 n = random.direction();
    pushes.push_back({0.03 * n + 1e-3 * random.direction(), n, random.uniform(-5e-4, 1e-3), 50});
  }
  // a lattice, where many points are equally far
  for (int i = 0; i < 64; ++i)
    pushes.push_back({{1e-3 * (i % 8), 1e-3 * (i / 8), 0.1}, {0, 0, 1}, 1e-3, 50});
  const ClusterOptions options{8e-3, 0.5, 5e-4};
  const auto found = [&](std::span<const PointPush> points) {
    std::vector<PushCluster> clusters(64);
    clusters.resize(clustered(points, options, clusters));
    return clusters;
  };
  const std::vector<PushCluster> first = found(pushes);
  CHECK(first.size() > 20);
  for (int k = 0; k < 10; ++k) {
    for (size_t i = pushes.size() - 1; i > 0; --i) {
      std::swap(
          pushes[i],
          pushes[std::min(i, static_cast<size_t>(random.uniform(0, static_cast<double>(i + 1))))]);
    }
    const std::vector<PushCluster> again = found(pushes);
    REQUIRE(again.size() == first.size());
    for (size_t i = 0; i < first.size(); ++i) {
      REQUIRE_THAT(again[i].point_O, IsNear(first[i].point_O, 1e-12));
      REQUIRE_THAT(again[i].normal_O, IsNear(first[i].normal_O, 1e-12));
      REQUIRE(again[i].depth == Approx(first[i].depth).margin(1e-12));
      REQUIRE(again[i].count == first[i].count);
    }
  }
}

TEST_CASE("clusters: opposite normals are not merged though there is no room", "[contact][trap]") {
  std::vector<PointPush> pushes;
  for (int i = 0; i < 20; ++i) {
    pushes.push_back({{1e-3, 1e-4 * i, 0}, {1, 0, 0}, 1e-4, 100});
    pushes.push_back({{-1e-3, 1e-4 * i, 0}, {-1, 0, 0}, 1e-4, 100});
  }
  std::array<PushCluster, 1> one;
  REQUIRE(clustered(pushes, {5e-3, 0.5}, one) == 1);
  CHECK(one[0].count == 20);
  CHECK(one[0].depth == Approx(1e-4).epsilon(1e-3));
  CHECK(std::fabs(one[0].normal_O.x) == Approx(1));
}

TEST_CASE("clusters: a point enters with weight zero", "[contact][trap]") {
  // among those that push at depth 0, among those that approach at the tolerance
  const double tolerance = 1e-3;
  for (const bool approaches : {false, true}) {
    const double edge = approaches ? -tolerance : 0;
    std::vector<PointPush> pushes = flat_patch(10, 2e-3, edge + 3e-4, 50);
    const ClusterOptions options{5e-3, 0.5, tolerance};
    std::array<PushCluster, 4> before, after;
    REQUIRE(clustered(pushes, options, before) == 1);
    pushes.push_back({{3e-3, 0, 0}, normalized(Vec3{0.2, 0, 1}), edge + 1e-10, 50});
    REQUIRE(clustered(pushes, options, after) == 1);
    CAPTURE(approaches);
    CHECK(after[0].count == 11);
    CHECK(norm(after[0].point_O - before[0].point_O) < 1e-8);
    CHECK(norm(after[0].normal_O - before[0].normal_O) < 1e-6);
    const double force = before[0].stiffness * before[0].depth;
    CHECK(after[0].stiffness * after[0].depth == Approx(force).epsilon(approaches ? 0.2 : 1e-5));
    if (approaches) CHECK(after[0].depth == before[0].depth);
  }
  // the shared stiffness as well
  std::vector<PointPush> pushes = flat_patch(10, 2e-3, 3e-4, 50);
  share_stiffness(pushes, 1000, 4);
  const double alone = pushes[0].stiffness;
  pushes.push_back({{4e-3, 0, 0}, {0, 0, 1}, 1e-10, 50});
  share_stiffness(pushes, 1000, 4);
  CHECK(pushes[0].stiffness == Approx(alone).epsilon(1e-5));
}

TEST_CASE("clusters: they go on where they were a frame before", "[contact]") {
  ClusterMemory memory;
  std::array<PushCluster, 32> before, now;
  auto pushes = flat_patch(400, 0.02, 1e-3, 10);
  const ClusterOptions options{8e-3, 0.5};
  size_t n = 0;
  // the first frames settle
  for (int i = 0; i < 10; ++i) n = cluster_pushes(pushes, options, memory, before);
  REQUIRE(n > 4);
  for (int i = 0; i < 50; ++i) {
    for (PointPush& p : pushes) p.point_O.x += 1e-4;
    REQUIRE(cluster_pushes(pushes, options, memory, now) == n);
    for (size_t k = 0; k < n; ++k) {
      REQUIRE(norm(now[k].point_O - before[k].point_O - Vec3{1e-4, 0, 0}) < 1e-3);
    }
    before = now;
  }
}

TEST_CASE("clusters: how much a ball's normals diverge, and that a face's do not", "[contact]") {
  Random random(13);
  std::vector<PointPush> of_ball, of_face = flat_patch(100, 4e-3, 1e-4, 50);
  const double radius = 0.02;
  for (int i = 0; i < 100; ++i) {
    // normals point into the tool
    const Vec3 out = normalized(Vec3{0, 0, -1} + 0.2 * random.direction());
    of_ball.push_back({radius * out, -out, random.uniform(1e-5, 1e-4), 50});
  }
  std::array<PushCluster, 4> clusters;
  REQUIRE(clustered(of_ball, {0.01, 0.5}, clusters) == 1);
  CHECK(clusters[0].bulge == Approx(1 / radius).epsilon(1e-6));
  REQUIRE(clustered(of_face, {0.01, 0.5}, clusters) == 1);
  CHECK(clusters[0].bulge == 0);
}
