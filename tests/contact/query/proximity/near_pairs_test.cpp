// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/proximity/near_pairs.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "contact/query/box/box_distance.h"
#include "contact/query/proximity/mesh_distance.h"
#include "contact/query/proximity/near_front.h"
#include "contact/shape/parts/machine_parts.h"
#include "tests/support/convex/meshes.h"
#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

using Pairs = std::vector<TrianglePair>;

Pairs sorted(std::span<const NearPair> near) {
  Pairs pairs;
  for (const NearPair& pair : near) pairs.push_back(pair.triangles);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

Pairs cold(const MeshShapeData& A, const MeshShapeData& B, const Pose& X_AB, double band) {
  std::vector<NearPair> out(near_pairs(A.view(), B.view(), X_AB, band, {}));
  REQUIRE(near_pairs(A.view(), B.view(), X_AB, band, out) == out.size());
  REQUIRE(any_near_pair(A.view(), B.view(), X_AB, band) == !out.empty());
  return sorted(out);
}

struct Brute {
  Pairs near;
  double least = std::numeric_limits<double>::infinity();
};

/// All pairs of triangles.
Brute brute_force(const MeshShapeData& A, const MeshShapeData& B, const Pose& X_AB, double band) {
  const TriangleMesh mesh_A = A.mesh.view(), mesh_B = B.mesh.view();
  Brute all;
  for (uint32_t a = 0; a < mesh_A.triangles.size(); ++a) {
    for (uint32_t b = 0; b < mesh_B.triangles.size(); ++b) {
      const double d =
          triangle_distance(corners_of(mesh_A, a), corners_of(mesh_B, b, X_AB)).distance;
      if (d <= band) all.near.push_back({a, b});
      all.least = std::min(all.least, d);
    }
  }
  return all;
}

Pose screw_pose(double t, double turn, double pitch) {
  return {{1e-5 * std::sin(7 * t), 1e-5 * std::cos(5 * t), pitch * turn / 6.283185307179586},
          from_rotation_vector({0, 0, turn})};
}

}  // namespace

TEST_CASE("box distance: never more than that of what the boxes hold, nor useless") {
  Random random(1);
  const MeshShapeData sheet = build_shape(make_rough_sheet(8, 12, 0.5));
  const MeshShapeData ball = build_shape(make_icosphere(0.05, 2));
  const MeshShapeData far = [] {
    Soup soup = make_icosphere(0.05, 1);
    for (Vec3& v : soup.vertices) v = v + Vec3{50, -20, 30};
    return build_shape(soup);
  }();
  double bounds = 0, distances = 0;
  for (size_t trial = 0; trial < trials(20000); ++trial) {
    const MeshShapeData &A = trial % 2 == 0 ? sheet : ball, &B = trial % 3 == 0 ? far : ball;
    const CompactObb& a = A.tree.nodes[random.index(A.tree.nodes.size())].box;
    const CompactObb& b = B.tree.nodes[random.index(B.tree.nodes.size())].box;
    const Obb box_a = a.unpacked(), box_b = b.unpacked();
    const Quat q_AB = trial % 5 == 0 ? Quat{} : random.pose(1).q;
    const Vec3 apart = random.uniform(0, 0.1) * random.direction();
    const Pose X_AB{box_a.centre_O + apart - rotate(q_AB, box_b.centre_O), q_AB};
    const double bound = BoxDistance(X_AB).at_least(a, b);
    // the nearest found by descending from box to box: an upper bound of the distance
    const auto into = [](const Obb& box, const Vec3& p) {
      Vec3 q = box.R_BO * (p - box.centre_O);
      for (int i = 0; i < 3; ++i) q[i] = std::clamp(q[i], -box.half[i], box.half[i]);
      return box.centre_O + transpose(box.R_BO) * q;
    };
    Vec3 on_a = box_a.centre_O, on_b = box_b.centre_O;
    for (int step = 0; step < 60; ++step) {
      on_b = into(box_b, inverse(X_AB) * on_a);
      on_a = into(box_a, X_AB * on_b);
    }
    const double distance = norm(X_AB * on_b - on_a);
    REQUIRE(bound <= distance);
    // across that way they are nearly as far apart at least; across none further than any two of
    // their points
    const BoxDistance boxes(X_AB);
    const BoxDistance::Separation separate = boxes.separation(a, b);
    REQUIRE(separate.at_least == bound);
    const double size = norm(box_a.half) + norm(box_b.half);
    if (bound > 0) {
      const double along = boxes.along(normalized(separate.way_A), a, b);
      REQUIRE(along > 0.999 * bound - 3e-4 * size);
    }
    const Vec3 n = trial % 2 == 0 ? random.direction() : normalized(X_AB * on_b - on_a);
    const Vec3 p_a =
        box_a.centre_O + transpose(box_a.R_BO) * random.in_box(-box_a.half, box_a.half);
    REQUIRE(boxes.along(n, a, b) <= dot(n, X_AB * on_b - p_a));
    REQUIRE(boxes.along(n, a, b) <= dot(n, X_AB * on_b - on_a));
    bounds += bound, distances += distance;
  }
  CHECK(bounds > 0.9 * distances);
}

TEST_CASE("near pairs: all that brute force finds, and the mesh distance with them") {
  Random random(2);
  const MeshShapeData shapes[] = {
      build_shape(make_box({0.06, 0.04, 0.05})), build_shape(make_icosphere(0.03, 2)),
      build_shape(make_rough_sheet(4, 8, 0.5)), build_shape(make_degenerate_soup(6, 60))};
  size_t n_near = 0;
  for (size_t trial = 0; trial < trials(100); ++trial) {
    const MeshShapeData &A = shapes[random.index(4)], &B = shapes[random.index(4)];
    const Pose X_AB = random.pose(random.uniform(0, 0.12));
    const double band = trial % 4 == 0 ? 0 : random.uniform(0, 0.02);
    const Brute all = brute_force(A, B, X_AB, band);
    CAPTURE(trial, band);
    REQUIRE(cold(A, B, X_AB, band) == all.near);
    n_near += all.near.size();
    const MeshDistance nearest = mesh_distance(A.view(), B.view(), X_AB);
    REQUIRE(nearest.found);
    REQUIRE(nearest.at_least == all.least);
    const TrianglePair witness{0, 0};
    const auto with = mesh_distance(A.view(), B.view(), X_AB, all.least + 1, &witness);
    REQUIRE(with.at_least == all.least);
    REQUIRE_FALSE(mesh_distance(A.view(), B.view(), X_AB, all.least).found);
    // ended early, it is a bound
    for (const size_t boxes : {0, 1, 8, 40, 200}) {
      DistanceSearch search;
      search.most_boxes = boxes;
      REQUIRE(mesh_distance(A.view(), B.view(), X_AB, search).at_least <= all.least);
    }
    DistanceSearch search;
    search.share = random.uniform(0.5, 1);
    const double least = mesh_distance(A.view(), B.view(), X_AB, search).at_least;
    REQUIRE(least <= all.least);
    REQUIRE(least >= search.share * all.least);
    search.least = 3 * all.least;
    REQUIRE(mesh_distance(A.view(), B.view(), X_AB, search).at_least == 0);
  }
  CHECK(n_near > 0);
}

TEST_CASE("near pairs: what does not fit is counted, and bad questions have no answer") {
  const MeshShapeData box = build_shape(make_box({0.05, 0.05, 0.05}));
  const Pose X{{0.051, 0.02, 0.005}, {}};
  std::vector<NearPair> few(1);
  CHECK(near_pairs(box.view(), box.view(), X, 0.002, few) > 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  NearFront front(box.view(), box.view());
  CHECK(!front.update(X, 0.002).empty());
  for (const double band : {nan, -1.0, std::numeric_limits<double>::infinity()}) {
    CHECK(near_pairs(box.view(), box.view(), X, band, few) == 0);
    CHECK(front.update(X, band).empty());
  }
  CHECK(near_pairs(box.view(), box.view(), {{nan, 0, 0}, {}}, 0.002, few) == 0);
  CHECK(front.update({{nan, 0, 0}, {}}, 0.002).empty());
  CHECK_FALSE(any_near_pair(box.view(), box.view(), {{nan, 0, 0}, {}}, 0.002));
  CHECK(sorted(front.update(X, 0.002)) == cold(box, box, X, 0.002));
  const MeshShapeData none = build_shape({});
  CHECK(NearFront(none.view(), box.view()).update(X, 0.002).empty());
  CHECK(NearFront(box.view(), none.view()).update(X, 0.002).empty());
  CHECK_FALSE(mesh_distance(none.view(), box.view(), X).found);
}

TEST_CASE("near front: as the cold search along paths, through jumps and changes of the band") {
  Random random(3);
  struct Course {
    MeshShapeData A, B;
    std::function<Pose(double)> path;  // at time t [s]
  };
  // rings of both at the same heights
  const primitive::Bolt bolt{{.grid = {12, 50}}};
  const primitive::Nut nut{{.grid = {12, 20}}};
  std::vector<Course> courses;
  courses.push_back({build_shape(make_torus(0.03, 0.008, 32, 16)),
                     build_shape(make_torus(0.03, 0.008, 28, 14)), [](double t) -> Pose {
                       return {{0.0436 + 0.002 * std::sin(9 * t), 0.003 * std::sin(5 * t), 0},
                               from_rotation_vector({1.57, 0.2 * std::sin(4 * t), 0}) *
                                   from_rotation_vector({0, 0, 0.7 * t})};
                     }});
  courses.push_back({build_shape(make_nut(nut)), build_shape(make_bolt(bolt)),
                     [&](double t) { return screw_pose(t, 2 * t, bolt.pitch); }});
  courses.push_back(
      {build_shape(make_rough_sheet(5, 16, 0.5)), build_shape(make_icosphere(0.02, 2)),
       [](double t) -> Pose {
         return {{0.02 * std::sin(3 * t), 0.02 * std::cos(2 * t), 0.021 + 0.002 * std::sin(8 * t)},
                 from_rotation_vector({t, 2 * t, 0})};
       }});
  courses.push_back({build_shape(make_degenerate_soup(6, 60)),
                     build_shape(make_box({0.3, 0.1, 0.2})), [](double t) -> Pose {
                       return {{std::sin(t), std::cos(2 * t), 0}, from_rotation_vector({t, 0, t})};
                     }});
  for (Course& course : courses) {
    NearFront front(course.A.view(), course.B.view());
    double t = 0, band = 5e-4;
    size_t n_near = 0;
    for (size_t tick = 0; tick < trials(120); ++tick) {
      t += 1e-3;
      if (tick % 31 == 20) t += random.uniform(0, 3);
      if (tick % 23 == 15) band = tick % 2 == 0 ? 0 : random.uniform(0, 1e-3);
      if (tick % 53 == 52) front.forget();
      const Pose X = course.path(t);
      CAPTURE(&course - courses.data(), tick, t, band);
      const Pairs expected = cold(course.A, course.B, X, band);
      // sometimes it is not queried, and catches up later
      if (tick % 5 == 3) continue;
      REQUIRE(sorted(front.update(X, band)) == expected);
      n_near += expected.size();
    }
    // under sanitizers the few poses may all be apart
    CHECK((n_near > 0 || kSlowdown > 1));
  }
}

TEST_CASE("near front: distances and places are those of the triangles") {
  const MeshShapeData A = build_shape(make_icosphere(0.05, 2)),
                      B = build_shape(make_icosphere(0.03, 2));
  NearFront front(A.view(), B.view());
  for (int tick = 0; tick < 50; ++tick) {
    const Pose X{{0.079 + 1e-4 * tick, 0, 0}, from_rotation_vector({0.01 * tick, 0, 0})};
    for (const NearPair& pair : front.update(X, 3e-3)) {
      const Corners a = corners_of(A.mesh.view(), pair.triangles.a);
      const Corners b = corners_of(B.mesh.view(), pair.triangles.b, X);
      const TriangleDistance one = triangle_distance(a, b);
      REQUIRE(pair.at.distance == one.distance);
      REQUIRE(pair.at.point_a == one.point_a);
      REQUIRE(pair.at.point_b == one.point_b);
    }
  }
}

TEST_CASE("near front: small steps look at little, and it does not grow without end") {
  const MeshShapeData A = build_shape(make_torus(0.03, 0.008, 100, 50));
  const MeshShapeData B = build_shape(make_torus(0.03, 0.008, 80, 40));
  NearFront front(A.view(), B.view());
  const auto path = [](double t) -> Pose {
    return {{0.0462, 0.003 * std::sin(5 * t), 0}, from_rotation_vector({1.57, 0, 0.7 * t})};
  };
  front.update(path(0), 1e-4);
  const size_t boxes = front.work().boxes;
  size_t most = 0, size_early = 0;
  for (size_t tick = 1; tick < trials(6000); ++tick) {
    front.update(path(1e-3 * static_cast<double>(tick)), 1e-4);
    most = std::max(most, front.work().boxes);
    if (tick == trials(6000) / 3) size_early = front.size();
  }
  CHECK(most < boxes / 2);
  CHECK(front.size() < 2 * size_early);
}

TEST_CASE("near front: bunny on bunny as the cold search") {
  const Soup soup = load_off("bunny00.off", 0.1);
  if (soup.triangles.empty() || kSlowdown > 1) return;
  const MeshShapeData bunny = build_shape(soup);
  NearFront front(bunny.view(), bunny.view());
  for (int tick = 0; tick < 24; ++tick) {
    const double t = 1e-3 * tick + (tick > 20 ? 1 : 0);
    const Pose X{{0.062 + 0.002 * std::sin(20 * t), 0.01 * std::sin(3 * t), 0},
                 from_rotation_vector({0.3 * t, 0.2, t})};
    REQUIRE(sorted(front.update(X, 2e-4)) == cold(bunny, bunny, X, 2e-4));
  }
}
