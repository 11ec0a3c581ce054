// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/solve/guide_rows.cpp: rows that hold both ways, against the optimality conditions
// of the projection and poses that were made.
#include "servo/solve/guide_rows.h"

#include <random>

#include "tests/support/least_squares.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kRadius = 0.03;  // of the tool [m]

struct Random {
  std::mt19937 engine{7};
  double number(double size) { return std::uniform_real_distribution<double>(-size, size)(engine); }
  Vec3 vector(double size) { return {number(size), number(size), number(size)}; }
  Pose pose(double way, double angle) {
    return {vector(way), from_rotation_vector(angle * normalized(vector(1)))};
  }
};

GuideRow row_of(const Pose& X_OT, const Vec3& point_T, const Vec3& normal_O, uint32_t index) {
  GuideRow row{};
  row.tool_point_T = point_T;
  row.object_point_O = X_OT * point_T;
  row.normal_O = normal_O;
  row.object = 2;
  row.row = index;
  return row;
}

/// Some of the six rows that fix a body.
ContactSet rows_of(Random& random, const Pose& X_OT, uint32_t n) {
  constexpr std::array<Vec3, 3> kAxes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const Vec3 centre_T = random.vector(0.05);
  ContactSet set{};
  for (uint32_t i = 0; i < n; ++i) {
    const Vec3 point_T = centre_T + (i < 3 ? 0 : kRadius) * kAxes[(i + 2) % 3];
    set.guides.push_back(row_of(X_OT, point_T, rotate(X_OT.q, kAxes[i % 3]), i));
  }
  return set;
}

MotionMetric springs() {
  return factor_metric(spring_matrix(800, 0.4));
}

}  // namespace

TEST_CASE("guide rows: those of a set, of one object, and no contacts", "[servo][guide]") {
  Random random;
  ContactSet set = rows_of(random, random.pose(0.1, 1), 3);
  set.contacts.push_back({});
  CHECK(guide_rows(set).rows.size() == 3);
  CHECK(guide_rows(set).object == 2);
  TickScene scene;
  scene.X_WO.resize(3);
  scene.V_WO.resize(3);
  CHECK(carry_contacts(set, scene).size == 1);
  set.guides[2].object = 1;
  CHECK(guide_rows(set).rows.empty());
  set.guides[2].object = 2;
  set.guides[1].normal_O.x = std::numeric_limits<double>::quiet_NaN();
  CHECK(guide_rows(set).object == kMaxObjects);
}

TEST_CASE("guide rows: six rows give back the pose that they were made at", "[servo][guide]") {
  Random random;
  const double angle = GENERATE(0.0, 0.1, 0.5);  // of the start [rad]
  CAPTURE(angle);
  for (int k = 0; k < 50; ++k) {
    const Pose X_OT = random.pose(0.1, 1), X_WO = random.pose(0.5, 3);
    const ContactSet set = rows_of(random, X_OT, 6);
    const Pose held = X_WO * X_OT;
    const Pose start{held.p + random.vector(0.05),
                     from_rotation_vector(angle * normalized(random.vector(1))) * held.q};
    // however far the hand is turned
    const Pose hand = moved(start, {random.vector(0.05), random.vector(1.5)});
    const Pose X = nearest_on_guides(guide_rows(set), X_WO, hand, start, springs());
    CHECK_THAT(X.p, IsNear(held.p, 1e-9));
    CHECK_THAT(to_rotation_vector(X.q * conjugate(held.q)), IsNear({}, 1e-9));
    const Pose next = nearest_on_guides(guide_rows(set), X_WO, hand, X, springs());
    CHECK_THAT(next.p, IsNear(held.p, 1e-13));
  }
}

TEST_CASE("guide rows: three of a point are met at once", "[servo][guide]") {
  Random random;
  for (int k = 0; k < 20; ++k) {
    const Pose X_WO = random.pose(0.5, 3), hand = random.pose(0.5, 3);
    const Vec3 place_O = random.vector(0.1);
    ContactSet set{};
    for (uint32_t i = 0; i < 3; ++i) {
      Vec3 normal_O;
      normal_O[static_cast<int>(i)] = 1;
      set.guides.push_back(row_of({place_O, {}}, {}, normal_O, i));
    }
    const Pose X = nearest_on_guides(guide_rows(set), X_WO, hand, hand, springs());
    CHECK_THAT(X.p, IsNear(X_WO * place_O, 1e-15));
    CHECK_THAT(to_rotation_vector(X.q * conjugate(hand.q)), IsNear({}, 1e-14));
  }
}

TEST_CASE("guide rows: fewer rows, KKT: each is an equation, and what pulls is a sum of them",
          "[servo][guide]") {
  Random random;
  const uint32_t n = GENERATE(1u, 2u, 3u, 4u, 5u);
  CAPTURE(n);
  constexpr double k_T = 800, k_R = 0.4;
  for (int trial = 0; trial < 50; ++trial) {
    const Pose X_OT = random.pose(0.1, 1), X_WO = random.pose(0.5, 3);
    const ContactSet set = rows_of(random, X_OT, n);
    const Pose held = X_WO * X_OT;
    const Pose hand = moved(held, {random.vector(0.002), random.vector(0.05)});
    Pose X = hand;
    for (int tick = 0; tick < 20; ++tick) {
      X = nearest_on_guides(guide_rows(set), X_WO, hand, X, springs());
    }
    Eigen::MatrixXd J(6, n);
    for (uint32_t i = 0; i < n; ++i) {
      const GuideRow& c = set.guides[i];
      const Vec3 n_W = rotate(X_WO.q, c.normal_O), r_W = rotate(X.q, c.tool_point_T);
      CHECK(std::fabs(dot(n_W, X * c.tool_point_T - X_WO * c.object_point_O)) < 1e-12);
      const Vec3 turn_W = cross(r_W, n_W);
      J.col(i) << n_W.x, n_W.y, n_W.z, turn_W.x, turn_W.y, turn_W.z;
    }
    const Twist way = way_between(X, hand);
    Eigen::VectorXd F(6);
    F << k_T * way.v.x, k_T * way.v.y, k_T * way.v.z, k_R * way.w.x, k_R * way.w.y, k_R * way.w.z;
    const Eigen::VectorXd rest = F - J * shortest_solution(J, F);
    CHECK(rest.norm() < 1e-8);
  }
}

TEST_CASE("guide rows: rows that say the same many times are one", "[servo][guide][trap]") {
  Random random;
  const Pose X_OT = random.pose(0.1, 1), X_WO = random.pose(0.5, 3);
  ContactSet set = rows_of(random, X_OT, 2);
  const Pose hand = moved(X_WO * X_OT, {random.vector(0.01), random.vector(0.1)});
  const Pose once = nearest_on_guides(guide_rows(set), X_WO, hand, hand, springs());
  while (!set.guides.full()) set.guides.push_back(set.guides[1]);
  const Pose often = nearest_on_guides(guide_rows(set), X_WO, hand, hand, springs());
  CHECK_THAT(often.p, IsNear(once.p, 1e-12));
}
