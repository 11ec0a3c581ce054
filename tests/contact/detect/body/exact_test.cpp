// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/exact.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <numbers>

#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kAlgebraTolerance = 1e-12;

/// Capacity for a few thousand pairs.
struct Room {
  std::vector<TrianglePair> pairs = std::vector<TrianglePair>(20000);
  std::vector<PointPush> pushes = std::vector<PointPush>(kPushesPerPair * 20000);
  ExactScratch scratch() { return {pairs, pushes}; }
};

std::vector<PointPush> pushes_of(const MeshShapeData& object, const MeshShapeData& tool,
                                 const Pose& X_OT) {
  std::vector<TrianglePair> pairs(triangle_pairs(object.view(), tool.view(), X_OT, {}));
  triangle_pairs(object.view(), tool.view(), X_OT, pairs);
  std::vector<PointPush> pushes(kPushesPerPair * pairs.size());
  const MeshShape O = object.view(), T = tool.view();
  pushes.resize(pushes_from_pairs(O.mesh, T.mesh, X_OT, pairs, 1000, pushes));
  return pushes;
}

/// A pyramid that points down to the origin.
Soup make_foot(double width, double height) {
  const double w = 0.5 * width;
  return {{{0, 0, 0}, {-w, -w, height}, {w, -w, height}, {w, w, height}, {-w, w, height}},
          {{0, 2, 1}, {0, 3, 2}, {0, 4, 3}, {0, 1, 4}, {1, 2, 3}, {1, 3, 4}}};
}

/// n × n feet over `side` × `side`: a box that touches a plane at n² points.
Soup make_brush(double side, size_t n) {
  Soup brush;
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = 0; j < n; ++j) {
      const auto place = [&](size_t k) {
        return side * (static_cast<double>(k) / static_cast<double>(n - 1) - 0.5);
      };
      append(brush, make_foot(0.2e-3, 0.5e-3), {place(i), place(j), 0});
    }
  }
  return brush;
}

double stiffness_along_z(const std::function<double(double)>& force_at, double z) {
  const double h = 1e-6;
  return (force_at(z - h) - force_at(z + h)) / (2 * h);
}

}  // namespace

TEST_CASE("exact: stiffness of n contact points is n k, and clustered it is bounded") {
  // ∂F/∂z = n·k: box of side L on a plane with 4 to 400 contact points
  const double side = 20e-3, k = 1000;
  // on one triangle of the plane: where triangles meet, each would push
  const MeshShapeData plane = build_shape(make_grid(0.1, 1));
  Room room;
  for (const size_t n : {2u, 4u, 10u, 20u}) {
    const MeshShapeData brush = build_shape(make_brush(side, n));
    const auto direct = [&](double z) {
      return sum_pushes(pushes_of(plane, brush, {{0.05, -0.05, z}, {}}), {}).F0_O.f.z;
    };
    const auto points = static_cast<double>(n * n);
    CHECK(stiffness_along_z(direct, -1e-4) == Approx(points * k).epsilon(1e-6));
    const auto clustered = [&](double radius) {
      return [&, radius](double z) {
        std::vector<PushCluster> clusters(64);
        PushOptions options;
        options.stiffness = k;
        options.clusters.radius = radius;
        const Pose X_OT{{0.05, -0.05, z}, {}};
        ClusterMemory memory;
        clusters.resize(exact_contacts(plane.view(), brush.view(), X_OT, options, memory,
                                       room.scratch(), clusters)
                            .n_clusters);
        double sum = 0;
        for (const PushCluster& c : clusters) sum += c.stiffness * c.depth * c.normal_O.z;
        return sum;
      };
    };
    // as four corners, in one cluster as in many
    for (const double radius : {2 * side, 5e-3}) {
      CHECK(stiffness_along_z(clustered(radius), -1e-4) == Approx(4 * k).epsilon(1e-4));
    }
  }
}

TEST_CASE("exact: a box sunk into a plane is pushed out at its four corners") {
  const MeshShapeData plane = build_shape(make_grid(0.05, 1));
  const MeshShapeData box = build_shape(make_box({0.01, 0.02, 0.01}));
  // on one triangle of the plane
  const double depth = 1e-3;
  const Pose X_OT{{0.025, -0.02, 0.005 - depth}, {}};
  const std::vector<PointPush> pushes = pushes_of(plane, box, X_OT);
  REQUIRE(pushes.size() == 4);
  for (const PointPush& push : pushes) {
    CHECK_THAT(push.normal_O, IsNear({0, 0, 1}, kAlgebraTolerance));
    CHECK(push.depth == Approx(depth).epsilon(1e-9));
    CHECK(std::fabs(push.point_O.x - 0.025) == Approx(0.005));
    CHECK(std::fabs(push.point_O.y + 0.02) == Approx(0.01));
  }
  // it rests on two triangles in the same way
  const Wrench F = sum_pushes(pushes_of(plane, box, {{0, 0, 0.005 - depth}, {}}), {}).F0_O;
  CHECK(F.f.z >= 4 * 1000 * depth * (1 - 1e-9));
  CHECK(norm(Vec3{F.f.x, F.f.y, 0}) < tol(kAlgebraTolerance));
}

TEST_CASE("exact: a corner of the object in a face of the tool pushes as the other way round") {
  const MeshShapeData foot = build_shape(make_foot(2e-3, 5e-3));
  const MeshShapeData plate = build_shape(make_box({0.1, 0.1, 0.02}));
  const double depth = 2e-4;
  // the tool's corner in the object's upper face
  std::vector<PointPush> pushes = pushes_of(plate, foot, {{0.013, 0.002, 0.01 - depth}, {}});
  REQUIRE(pushes.size() == 1);
  CHECK_THAT(pushes[0].normal_O, IsNear({0, 0, 1}, kAlgebraTolerance));
  CHECK(pushes[0].depth == Approx(depth));
  // the object's corner in the tool's lower face: the tool is below it and goes down
  pushes = pushes_of(foot, plate, {{0.013, 0.002, -0.01 + depth}, {}});
  REQUIRE(pushes.size() == 1);
  CHECK_THAT(pushes[0].normal_O, IsNear({0, 0, -1}, kAlgebraTolerance));
  CHECK_THAT(pushes[0].point_O, IsNear({}, kAlgebraTolerance));
  CHECK(pushes[0].depth == Approx(depth));
}

TEST_CASE("exact: two crossed edges push along what is perpendicular to both") {
  // bars standing on an edge: one along x, one along y above it
  const double w = 0.01, half_diagonal = w / std::sqrt(2.0), depth = 5e-4;
  const auto turned = [](Soup soup, const Vec3& about) {
    for (Vec3& v : soup.vertices) v = rotate(from_rotation_vector(about), v);
    return soup;
  };
  const double eighth = std::numbers::pi / 4;
  const MeshShapeData lower = build_shape(turned(make_box({0.1, w, w}), {eighth, 0, 0}));
  const MeshShapeData upper = build_shape(turned(make_box({w, 0.1, w}), {0, eighth, 0}));
  const double up = 2 * half_diagonal;
  const auto force = [&](double d) {
    return sum_pushes(pushes_of(lower, upper, {{1e-3, 2e-3, up - d}, {}}), {}).F0_O;
  };
  CHECK(force(-1e-6).f == Vec3{});
  // one push for four pairs of faces, where the edges cross
  const std::vector<PointPush> pushes = pushes_of(lower, upper, {{1e-3, 2e-3, up - depth}, {}});
  REQUIRE(pushes.size() == 1);
  CHECK_THAT(pushes[0].point_O, IsNear({1e-3, 0, half_diagonal - depth}, kAlgebraTolerance));
  CHECK_THAT(pushes[0].normal_O, IsNear({0, 0, 1}, kAlgebraTolerance));
  CHECK(pushes[0].depth == Approx(depth));
  // grows from nothing
  CHECK(force(1e-7).f.z == Approx(1000 * 1e-7));
}

TEST_CASE("exact: two balls push along the line of their centres, from object to tool") {
  Random random(1);
  const MeshShapeData object = build_shape(make_icosphere(0.03, 3));
  const MeshShapeData tool = build_shape(make_icosphere(0.02, 3));
  for (size_t trial = 0; trial < trials(20); ++trial) {
    const Vec3 way = random.direction();
    const double depth = random.uniform(5e-4, 3e-3);
    const Pose X_OT{(0.05 - depth) * way, random.pose(1).q};
    const std::vector<PointPush> pushes = pushes_of(object, tool, X_OT);
    const Vec3 F = sum_pushes(pushes, {}).F0_O.f;
    // edges of the balls span 0.15 rad
    CHECK(dot(normalized(F), way) > std::cos(0.15));
    for (const PointPush& push : pushes) {
      CHECK(push.depth >= 0);
      CHECK(push.depth < 1.1 * depth);
      CHECK(dot(push.normal_O, way) > 0.5);
    }
  }
}

TEST_CASE("exact: numbering does not matter, and a common motion only moves the forces") {
  Random random(2);
  Soup sheet = make_rough_sheet(3, 10, 0.5), ball = make_icosphere(0.02, 2);
  const MeshShapeData object = build_shape(sheet), tool = build_shape(ball);
  const Pose X_OT{{0.003, 0.004, 0.015}, random.pose(1).q}, X = random.pose(0.5);
  const std::vector<PointPush> pushes = pushes_of(object, tool, X_OT);
  REQUIRE(pushes.size() > 10);

  std::reverse(sheet.triangles.begin(), sheet.triangles.end());
  std::rotate(ball.triangles.begin(), ball.triangles.begin() + 57, ball.triangles.end());
  const std::vector<PointPush> renumbered = pushes_of(build_shape(sheet), build_shape(ball), X_OT);
  REQUIRE(renumbered.size() == pushes.size());
  for (size_t i = 0; i < pushes.size(); ++i) CHECK(renumbered[i].point_O == pushes[i].point_O);

  for (Vec3& v : sheet.vertices) v = X * v;
  const Wrench F = sum_pushes(pushes, {}).F0_O;
  const Wrench F_moved = sum_pushes(pushes_of(build_shape(sheet), tool, X * X_OT), X.p).F0_O;
  CHECK_THAT(F_moved.f, IsNear(rotate(X.q, F.f), 1e-9));
  CHECK_THAT(F_moved.t, IsNear(rotate(X.q, F.t), 1e-9));
}

TEST_CASE("exact: sliding slowly the force changes less than without clusters") {
  // a ball of triangles over a sheet of triangles at 5 mm/s: places come and go all the time
  const MeshShapeData sheet = build_shape(make_grid(0.05, 25));
  const MeshShapeData ball = build_shape(make_icosphere(8e-3, 3));
  Room room;
  ClusterMemory memory;
  std::vector<PushCluster> clusters(16);
  struct Change {
    double largest = 0, sum = 0, mean = 0;
    Vec3 last;
    void see(const Vec3& f, bool is_first) {
      if (!is_first) largest = std::max(largest, norm(f - last)), sum += norm(f - last);
      mean += f.z;
      last = f;
    }
  } all, few;
  for (int i = 0; i < 400; ++i) {
    const Pose X_OT{{5e-6 * i, 0.3e-3 + 2e-6 * i, 7.6e-3}, {}};
    const ExactAnswer answer =
        exact_contacts(sheet.view(), ball.view(), X_OT, {}, memory, room.scratch(), clusters);
    Vec3 sum;
    for (size_t k = 0; k < answer.n_clusters; ++k) {
      sum += clusters[k].stiffness * clusters[k].depth * clusters[k].normal_O;
    }
    few.see(sum, i == 0);
    all.see(sum_pushes(pushes_of(sheet, ball, X_OT), {}).F0_O.f, i == 0);
  }
  CAPTURE(all.largest, few.largest, all.sum, few.sum, all.mean, few.mean);
  CHECK(few.mean > 0);
  CHECK(few.largest < all.largest);
  CHECK(few.sum < all.sum);
  // also as a share of the force
  CHECK(few.largest / few.mean < all.largest / all.mean);
  CHECK(few.sum / few.mean < all.sum / all.mean);
}

TEST_CASE("exact: pairs without room are counted, and apart there is nothing") {
  const MeshShapeData object = build_shape(make_icosphere(0.03, 3));
  Room room;
  std::vector<PushCluster> clusters(16);
  ClusterMemory memory;
  const Pose X_OT{{0.04, 0, 0}, {}};
  const ExactAnswer all =
      exact_contacts(object.view(), object.view(), X_OT, {}, memory, room.scratch(), clusters);
  REQUIRE(all.n_pairs > 20);
  CHECK(all.left_out == 0);
  CHECK(all.n_clusters > 0);
  const ExactScratch little{{room.pairs.data(), 20}, {room.pushes.data(), 30}};
  const ExactAnswer few =
      exact_contacts(object.view(), object.view(), X_OT, {}, memory, little, clusters);
  CHECK(few.n_pairs == all.n_pairs);
  CHECK(few.left_out == all.n_pairs - 10);
  const ExactAnswer none = exact_contacts(object.view(), object.view(), {{0.07, 0, 0}, {}}, {},
                                          memory, room.scratch(), clusters);
  CHECK(none.n_pairs + none.n_pushes + none.n_clusters + none.left_out == 0);
}
