// SPDX-License-Identifier: GPL-3.0-or-later
// The kinematics of all devices: what holds for each of them, whatever its lengths. Rows of numbers
// of independent programs and poses by hand are in the tests of each.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "device-io/falcon/falcon.h"
#include "device-io/falcon/kinematics.h"
#include "device-io/haply/haply.h"
#include "device-io/hidarm/hid_arm.h"
#include "device-io/owndevice/own_device_arm.h"
#include "device-io/polhem/kinematics.h"
#include "device-io/sixmotors/kinematics.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

using Columns = HandleJacobian;

/// The kinematics of a device, of as many joints as it has motors.
struct ArmRow {
  std::string name;
  size_t motors = 3;
  Vec3 middle_B{};             // of its workspace
  Vec3 reach_B;                // half axes of the workspace [m]
  double turn = 0;             // of the handle, up to [rad]
  Vec3 far_B{0.5, 0, 0};       // out of reach; the origin: there is no such place
  double inverse = 1e-9;       // of angles found for a pose [m]
  double turn_inverse = 1e-7;  // [rad]
  double slope = 1e-8;         // of differences against the Jacobian [m/rad]
  double unit = 1e-4;          // a step of a joint for them [rad]
  double wrench_step = 1e-9;

  std::function<bool(const Pose& X_BH, JointAngles& q)> solve;
  std::function<bool(const JointAngles& q, Pose& X_BH)> pose;
  /// True for the solution that the driver chooses where several angles reach one pose.
  bool (*is_meant)(const JointAngles& q) = [](const JointAngles&) { return true; };
  /// Columns of the Jacobian: the handle's twist per velocity of each joint; empty: there is none.
  std::function<Columns(const JointAngles& q, const Pose& X_BH)> jacobian;
  /// Motor currents of a wrench, the wrench of motor currents, and the work of one unit of a motor
  /// over one unit of its joint [J]; empty: there are none.
  std::function<MotorEfforts(const JointAngles& q, const Pose& X_BH, const Wrench& F_B)> drive;
  std::function<Wrench(const JointAngles& q, const Pose& X_BH, const MotorEfforts&)> wrench;
  std::array<double, kMostMotors> work{};
  /// Encoder counts of angles, rounded down, and the angles of counts; empty: none are known here.
  std::function<MotorCounts(const JointAngles& q)> counts;
  std::function<JointAngles(const MotorCounts&)> angles;
  size_t encoders = 3;
  /// Lengths of its links in space, each over that of the drawing.
  std::function<std::vector<double>(const JointAngles& q, const Vec3& p_B)> links;
  double count = 0, least_step = 0, most_step = 0;  // angle of a count, and what it moves [rad, m]
};

bool is_elbow_up(const JointAngles& q) {
  return q[1] + q[2] > 0 && q[1] + q[2] < std::numbers::pi;
}

/// The row of a driver's arm, and the angles of a pose where the driver knows none.
ArmRow row_of(const Arm& arm, const Vec3& reach_B, double turn = 0,
              std::function<bool(const Pose&, JointAngles&)> solve = {}) {
  ArmRow row;
  row.name = arm.name;
  row.motors = arm.motors;
  row.reach_B = reach_B;
  row.turn = turn;
  row.encoders = arm.encoders;
  row.counts = [arm](const JointAngles& q) { return arm.counts(q); };
  row.angles = [arm](const MotorCounts& n) { return arm.angles(n); };
  row.solve = solve ? std::move(solve) : arm.solve;
  row.pose = arm.find;
  row.jacobian = [arm](const JointAngles& q, const Pose& X_BH) {
    Columns J{};
    REQUIRE(arm.jacobian(q, X_BH, J));
    return J;
  };
  row.drive = [arm](const JointAngles& q, const Pose& X_BH, const Wrench& F) {
    MotorEfforts motors;
    REQUIRE(arm.efforts(q, X_BH, F, motors));
    return motors;
  };
  if (arm.motors > 2) {
    row.wrench = [arm](const JointAngles& q, const Pose&, const MotorEfforts& motors) {
      return arm.wrench(q, motors);
    };
  }
  return row;
}

/// In space, from the lengths of hfab_polhem.h.
std::vector<double> polhem_links(const JointAngles& q, const Vec3& p_B) {
  const Vec3 out{std::cos(q[0]), std::sin(q[0]), 0}, up{0, 0, 1};
  const Vec3 elbow = 0.017 * out + 0.165 * (std::cos(q[1]) * out + std::sin(q[1]) * up);
  const Vec3 crank = -0.017 * out + 0.025 * (std::cos(q[2]) * out + std::sin(q[2]) * up);
  const Vec3 handle = p_B + Vec3{0.2045, 0, 0.0325};
  const Vec3 tail = elbow - 0.034 / 0.1308 * (handle - elbow);
  return {norm(handle - elbow) / 0.1308, norm(tail - crank) / 0.190};
}

/// Elbows outwards.
std::vector<double> pantograph_links(const JointAngles& q, const Vec3& p_B) {
  const Vec3 first{-0.01 + 0.05 * std::cos(q[0]), 0.05 * std::sin(q[0]), 0};
  const Vec3 second{0.01 + 0.05 * std::cos(q[1]), 0.05 * std::sin(q[1]), 0};
  REQUIRE(first.x < p_B.x);
  REQUIRE(second.x > p_B.x);
  return {norm(p_B - first) / 0.07, norm(p_B - second) / 0.07};
}

/// A parallelogram keeps the plate parallel, so the rod's length is that between the joints'
/// middles.
std::vector<double> falcon_rods(const JointAngles& q, const Vec3& p_B) {
  std::vector<double> rods;
  for (size_t i = 0; i < 3; ++i) {
    const double phi = std::numbers::pi / 180 * (105 - 120 * static_cast<int>(i));
    const Vec3 out{std::cos(phi), std::sin(phi), 0}, side{-std::sin(phi), std::cos(phi), 0};
    const Vec3 up{0, 0, 1};
    const Vec3 knee = 0.040 * out - 0.02309 * side +
                      0.060 * (std::cos(q[i]) * out + std::sin(q[i]) * up) - 0.125 * up;
    const Vec3 leg = p_B + 0.01443 * out - 0.025 * side - knee;
    // the two ends of the rod stand off by d and e within the leg's plane
    const double across = dot(leg, side);
    rods.push_back(std::hypot(norm(leg - across * side) - 2 * 0.01125, across) / 0.1025);
  }
  return rods;
}

/// The row of an arm of three bodies. A turn of a motor has the same number of counts whichever
/// body it drives, so its work is independent of capstans and signs.
ArmRow serial_arm_row(const char* name, const Arm& arm) {
  ArmRow row = row_of(arm, {0.14, 0.14, 0.14});
  row.name = name;
  row.inverse = row.wrench_step = 1e-12;
  row.slope = 1e-10;
  row.is_meant = is_elbow_up;
  return row;
}

ArmRow woodenhaptics() {
  ArmRow row = serial_arm_row("WoodenHaptics", woodenhaptics_arm());
  row.work.fill(0.0259 * 2 * std::numbers::pi / 2000);
  return row;
}

ArmRow hid_arm_row(const char* name, const HidArmConfig& config) {
  ArmRow row = serial_arm_row(name, hid_arm(config));
  const double count = 2 * std::numbers::pi / config.counts_per_turn;
  const auto motor = [&](int i) {
    return config.signs[i] * config.motor_signs[i] * config.torque_constant * count;
  };
  row.work = {motor(0), motor(1), motor(2)};
  return row;
}

ArmRow six_motors() {
  ArmRow row = row_of(six_motors_arm(), {0.14, 0.14, 0.14}, 1);
  row.inverse = 1e-12;
  row.turn_inverse = 1e-10;
  row.wrench_step = 1e-11;
  row.slope = 1e-9;
  row.is_meant = is_elbow_up;
  // and 0.0138 N·m and 4096 counts in the wrist
  const double arm = 0.0259 * 2 * std::numbers::pi / 2000;
  const double wrist = 0.0138 * 2 * std::numbers::pi / 4096;
  row.work = {arm, arm, arm, wrist, wrist, wrist};
  return row;
}

ArmRow polhem() {
  ArmRow row = row_of(polhem_arm(), {0.09, 0.09, 0.09}, 3.1);
  row.is_meant = [](const JointAngles& q) { return q[4] <= 0; };
  row.far_B = {0.2, 0, 0};
  const double count = 2 * std::numbers::pi / 4096;
  row.links = polhem_links;
  row.work = {0.0603 * count, 0.0538 * count, 0.0538 * count};
  return row;
}

/// Its joints are the pose itself, and its torques no derivative of the rotation vector.
ArmRow own_device() {
  ArmRow row = row_of(own_device_arm(), {0.5, 0.5, 0.5}, 2.9);
  row.far_B = {};
  row.turn_inverse = 1e-9;
  row.wrench_step = 1e-11;
  row.jacobian = {};
  return row;
}

/// With v from motor to handle, θ = atan2(v) ± acos((l² + v² − L²)/(2 l v)), plus for link 1.
bool solve_pantograph(const PantographConfig& g, const Vec3& p_B, JointAngles& q) {
  std::array<double, 2> found;
  for (int i = 0; i < 2; ++i) {
    const double side = i == 0 ? 1 : -1;
    const Vec3 v{p_B.x + side * g.base / 2, p_B.y, 0};
    const double reach = norm(v);
    const double cosine =
        (g.proximal * g.proximal + reach * reach - g.distal * g.distal) / (2 * g.proximal * reach);
    if (!(std::fabs(cosine) <= 1)) return false;
    found[static_cast<size_t>(i)] = std::atan2(v.y, v.x) + side * std::acos(cosine);
  }
  std::ranges::copy(found, q.begin());
  return true;
}

ArmRow pantograph(const char* name, const PantographConfig& config) {
  ArmRow row = row_of(
      haply_arm(config), {0.035, 0.035, 0}, 0,
      [config](const Pose& X_BH, JointAngles& q) { return solve_pantograph(config, X_BH.p, q); });
  row.name = name;
  row.middle_B = {0, 0.07, 0};
  row.far_B = {0, 0.2, 0};
  // a unit of a motor is a newton metre of its link
  const double count = 2 * std::numbers::pi / config.counts_per_turn;
  row.work = {count, count};
  return row;
}

ArmRow falcon() {
  static const FalconGeometry kGeometry;
  // from the middle: the worst start
  ArmRow row = row_of(falcon_arm({}), {0.05, 0.05, 0.05}, 0, [](const Pose& X_BH, JointAngles& q) {
    FalconPose pose;
    if (!solve_falcon(kGeometry, X_BH.p, pose)) return false;
    std::copy_n(&pose.angles.x, 3, q.begin());
    return true;
  });
  row.name = "Falcon";
  row.far_B = {0.2, 0, 0};
  row.work.fill(kGeometry.angle_per_count);
  row.links = falcon_rods;
  row.count = kGeometry.angle_per_count;
  row.least_step = 10e-6;
  row.most_step = 60e-6;
  return row;
}

ArmRow haply() {
  ArmRow row = pantograph("pantograph", {});
  row.links = pantograph_links;
  row.count = 2 * std::numbers::pi / 13'824;
  row.least_step = 10e-6;
  row.most_step = 50e-6;
  return row;
}

std::vector<ArmRow> arms() {
  HidArmConfig other;
  other.links = {0.111, 0.180, 0.211};
  other.capstans = {0.0138, 0.0098, 0.0098};
  other.bodies = {0.116, 0.076, 0.076};
  other.counts_per_turn = 4096;
  return {woodenhaptics(),
          six_motors(),
          polhem(),
          own_device(),
          falcon(),
          hid_arm_row("HID arm of 2016", {}),
          hid_arm_row("HID arm of other lengths", other),
          haply(),
          pantograph("pantograph with its motors on one axis",
                     {.proximal = 0.07, .distal = 0.09, .base = 0}),
          pantograph("pantograph of short driven links",
                     {.proximal = 0.06, .distal = 0.09, .base = 0.05})};
}

/// Poses within the workspace of a row.
struct Draw {
  std::minstd_rand random{1};

  Vec3 in_ball() {
    std::uniform_real_distribution<double> one(-1, 1);
    for (;;) {
      const Vec3 a{one(random), one(random), one(random)};
      if (norm(a) <= 1) return a;
    }
  }
  Pose pose(const ArmRow& row) {
    const Vec3 a = in_ball(), r = row.reach_B;
    return {row.middle_B + Vec3{a.x * r.x, a.y * r.y, a.z * r.z},
            from_rotation_vector(row.turn * in_ball())};
  }
};

/// The angle by which one count of its motor turns a joint [rad]; the unit of its row where the row
/// has no angles.
double unit_of(const ArmRow& row, size_t joint) {
  if (!row.angles) return row.unit;
  MotorCounts one{};
  one[joint] = 1;
  return row.angles(one)[joint] - row.angles({})[joint];
}

/// Way and turn of the handle from one pose to another.
Twist between(const Pose& from, const Pose& to) {
  return {to.p - from.p, to_rotation_vector(to.q * conjugate(from.q))};
}

/// The handle with a joint moved on by some units.
Pose moved(const ArmRow& row, const JointAngles& q, size_t joint, double by) {
  JointAngles at = q;
  at[joint] += by;
  Pose X_BH;
  REQUIRE(row.pose(at, X_BH));
  return X_BH;
}

/// Calls visit(q, X_BH) for poses of the workspace.
template <typename Visit>
void visit_workspace(const ArmRow& row, int poses, Visit visit) {
  Draw draw;
  for (int n = 0; n < poses; ++n) {
    const Pose X_BH = draw.pose(row);
    JointAngles q{};
    REQUIRE(row.solve(X_BH, q));
    visit(q, X_BH, draw);
  }
}

}  // namespace

TEST_CASE("kinematics: forward after inverse is the identity over the workspace", "[device-io]") {
  const ArmRow row = GENERATE(from_range(arms()));
  double worst = 0, worst_turn = 0;
  visit_workspace(row, 3000, [&](const JointAngles& q, const Pose& X_BH, Draw&) {
    Pose found;
    REQUIRE(row.pose(q, found));
    const Twist off = between(X_BH, found);
    worst = std::max(worst, norm(off.v));
    REQUIRE(row.is_meant(q));
    if (row.turn > 0) worst_turn = std::max(worst_turn, norm(off.w));
  });
  CAPTURE(row.name, worst, worst_turn);
  CHECK(worst < row.inverse);
  CHECK(worst_turn < row.turn_inverse);
}

TEST_CASE("kinematics: encoders read the counts below the angles", "[device-io]") {
  const ArmRow row = GENERATE(from_range(arms()));
  if (!row.counts) return;
  INFO(row.name);
  visit_workspace(row, 300, [&](const JointAngles& q, const Pose&, Draw&) {
    const JointAngles below = row.angles(row.counts(q));
    for (size_t i = 0; i < row.encoders; ++i) {
      // along its own motor
      const double over = (q[i] - below[i]) / unit_of(row, i);
      CAPTURE(i);
      REQUIRE(over >= -tol(1e-8));
      REQUIRE(over < 1 + tol(1e-8));
    }
  });
}

TEST_CASE("kinematics: the Jacobian is the derivative of the pose", "[device-io]") {
  const ArmRow row = GENERATE(from_range(arms()));
  if (!row.jacobian) return;
  constexpr double kStep = 1e-5;
  double worst = 0, worst_turn = 0;
  visit_workspace(row, 500, [&](const JointAngles& q, const Pose& X_BH, Draw&) {
    const Columns J = row.jacobian(q, X_BH);
    for (size_t i = 0; i < row.motors; ++i) {
      const Twist way = between(moved(row, q, i, -kStep), moved(row, q, i, kStep));
      worst = std::max(worst, norm(J[i].v - way.v / (2 * kStep)));
      if (row.motors == 6) worst_turn = std::max(worst_turn, norm(J[i].w - way.w / (2 * kStep)));
    }
  });
  CAPTURE(row.name, worst, worst_turn);
  CHECK(worst < tol(row.slope));
  CHECK(worst_turn < tol(row.slope));
}

TEST_CASE("kinematics: motors do the work that the handle does", "[device-io]") {
  const ArmRow row = GENERATE(from_range(arms()));
  if (row.work[0] == 0) return;
  INFO(row.name);
  visit_workspace(row, 300, [&](const JointAngles& q, const Pose& X_BH, Draw& draw) {
    const Wrench F_B{5 * draw.in_ball(), row.motors == 6 ? 0.3 * draw.in_ball() : Vec3{}};
    const MotorEfforts motors = row.drive(q, X_BH, F_B);
    for (size_t i = 0; i < row.motors; ++i) {
      const double unit = unit_of(row, i);
      const Twist way = between(moved(row, q, i, -unit), moved(row, q, i, unit));
      CAPTURE(i);
      REQUIRE(std::fabs(dot(F_B.f, way.v) + dot(F_B.t, way.w) - 2 * row.work[i] * motors[i]) <=
              tol(1e-10));
    }
  });
}

TEST_CASE("kinematics: wrenches and what the motors do are each other's inverse", "[device-io]") {
  const ArmRow row = GENERATE(from_range(arms()));
  if (!row.wrench) return;
  INFO(row.name);
  visit_workspace(row, 1000, [&](const JointAngles& q, const Pose& X_BH, Draw& draw) {
    const Wrench F_B{20 * draw.in_ball(), row.motors == 6 ? 0.4 * draw.in_ball() : Vec3{}};
    const Wrench back = row.wrench(q, X_BH, row.drive(q, X_BH, F_B));
    REQUIRE_THAT(back.f, IsNear(F_B.f, row.wrench_step));
    REQUIRE_THAT(back.t, IsNear(F_B.t, row.wrench_step));
  });
}

TEST_CASE("kinematics: each link keeps its length, and a count is a small step", "[device-io]") {
  const ArmRow row = GENERATE(from_range(arms()));
  INFO(row.name);
  visit_workspace(row, 1000, [&](const JointAngles& q, const Pose& X_BH, Draw&) {
    if (!row.links) return;
    for (const double length : row.links(q, X_BH.p)) REQUIRE(std::fabs(length - 1) < tol(1e-11));
    if (row.count == 0) return;
    for (size_t i = 0; i < row.motors; ++i) {
      const double step = norm(moved(row, q, i, row.count).p - X_BH.p);
      REQUIRE(step > row.least_step);
      REQUIRE(step < row.most_step);
    }
  });
}

TEST_CASE("kinematics: out of reach is said, and the angles stay", "[device-io]") {
  const ArmRow row = GENERATE(from_range(arms()));
  if (row.far_B == Vec3{}) return;
  INFO(row.name);
  const JointAngles before{1, 2, 3, 4, 5, 6};
  const double nan = std::nan("");
  for (const Vec3& p_B : {row.far_B, Vec3{nan, 0, 0}, Vec3{0, nan, 0}}) {
    JointAngles q = before;
    CHECK_FALSE(row.solve({p_B, {}}, q));
    CHECK(q == before);
  }
}
