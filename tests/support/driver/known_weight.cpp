// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/driver/known_weight.h"

#include <cmath>
#include <utility>

#include "device-io/owndevice/own_device_arm.h"
#include "device-io/polhem/kinematics.h"
#include "device-io/sixmotors/kinematics.h"
#include "tests/support/driver/emulated_arm.h"
#include "tests/support/driver/falcon_bench.h"
#include "tests/support/driver/haply_bench.h"
#include "tests/support/driver/hid_arm_bench.h"

namespace haptic::test {
namespace {

/// Where two circles in the plane of x and y meet, to the left of the way from the first to the
/// second.
Vec3 meet(const Vec3& a, double radius_a, const Vec3& b, double radius_b) {
  const Vec3 way = b - a;
  const double d = norm(way);
  const double x = (d * d + radius_a * radius_a - radius_b * radius_b) / (2 * d);
  const double y = std::sqrt(radius_a * radius_a - x * x);
  return a + x / d * way + y / d * Vec3{-way.y, way.x, 0};
}

/// Mass times height of a link that goes from one joint towards another [kg·m], `y_B` being its
/// own y axis.
double raised(const LinkMass& link, const Vec3& from, const Vec3& to, const Vec3& y_B,
              const Vec3& up) {
  const Vec3 x_B = (to - from) / norm(to - from);
  const Vec3 place =
      from + link.centre.x * x_B + link.centre.y * y_B + link.centre.z * cross(x_B, y_B);
  return link.mass * dot(place, up);
}

/// A place of B in the upright plane through the axis at `foot` and the handle: x outwards, y up;
/// and back.
struct Upright {
  Vec3 foot, out, left;

  Upright(const Vec3& p_B, const Vec3& axis_foot) : foot(axis_foot) {
    const Vec3 way = p_B - foot;
    out = Vec3{way.x, way.y, 0} / std::hypot(way.x, way.y);
    left = {-out.y, out.x, 0};
  }
  Vec3 in(const Vec3& p_B) const { return {dot(p_B - foot, out), p_B.z - foot.z, 0}; }
  Vec3 back(const Vec3& p) const { return foot + p.x * out + Vec3{0, 0, p.y}; }
};

double wooden_moment(const GravityConfig& g, const Vec3& p_B, const Vec3& up) {
  const Upright plane(p_B, {-0.220, 0, -0.080});
  const Vec3 shoulder{0, 0.080, 0}, tip = plane.in(p_B);
  const Vec3 elbow = meet(shoulder, 0.205, tip, 0.245);
  return raised(g.links[0], plane.back(shoulder), plane.back(elbow), plane.left, up) +
         raised(g.links[1], plane.back(elbow), p_B, plane.left, up);
}

double polhem_moment(const GravityConfig& g, const Vec3& p_B, const Vec3& up) {
  const Upright plane(p_B, {-0.2045, 0, -0.0325});
  const Vec3 shoulder{0.017, 0, 0}, motor{-0.017, 0, 0}, tip = plane.in(p_B);
  const Vec3 elbow = meet(shoulder, 0.165, tip, 0.1308);
  const Vec3 tail = elbow - 0.034 / 0.1308 * (tip - elbow);
  const Vec3 crank = meet(motor, 0.025, tail, 0.190);
  return raised(g.links[0], plane.back(shoulder), plane.back(elbow), plane.left, up) +
         raised(g.links[1], plane.back(elbow), p_B, plane.left, up) +
         raised(g.links[2], plane.back(motor), plane.back(crank), plane.left, up);
}

double haply_moment(const GravityConfig& g, const Vec3& p_B, const Vec3& up) {
  double sum = 0;
  for (const double side : {-1.0, 1.0}) {
    const Vec3 motor{side * 0.01, 0, 0};
    // outside: to the left of the way of the left leg, to the right of the other's
    const Vec3 elbow = side < 0 ? meet(motor, 0.05, p_B, 0.07) : meet(p_B, 0.07, motor, 0.05);
    const auto outside = [&](const Vec3& way) {
      return -side / norm(way) * Vec3{-way.y, way.x, 0};
    };
    sum += raised(g.links[0], motor, elbow, outside(elbow - motor), up) +
           raised(g.links[1], elbow, p_B, outside(p_B - elbow), up);
  }
  return sum;
}

double falcon_moment(const GravityConfig& g, const Vec3& p_B, const Vec3& up) {
  double sum = 0;
  for (int leg = 0; leg < 3; ++leg) {
    const double azimuth = (105 - 120 * leg) * 3.14159265358979323846 / 180;
    const Vec3 out{std::cos(azimuth), std::sin(azimuth), 0}, left{-out.y, out.x, 0};
    const Vec3 motor = 0.040 * out - 0.02309 * left - Vec3{0, 0, 0.125};
    const Vec3 plate = p_B + 0.01443 * out - 0.025 * left;
    const auto knee_at = [&](double angle) {
      return motor + 0.060 * (std::cos(angle) * out + Vec3{0, 0, std::sin(angle)});
    };
    // both offsets lie in the leg's plane, between knee and rod and between rod and plate
    const auto rod_length = [&](double angle) {
      const Vec3 way = plate - knee_at(angle);
      const double across = dot(way, left), along = norm(way - across * left) - 2 * 0.01125;
      return std::hypot(across, along);
    };
    // within the workspace the arms lean between −50° and 80°, and rising shortens the rod
    double low = -0.9, high = 1.4;
    for (int n = 0; n < 42; ++n) {
      const double middle = (low + high) / 2;
      (rod_length(middle) > 0.1025 ? low : high) = middle;
    }
    const Vec3 knee = knee_at(low), way = plate - knee;
    const Vec3 level = way - dot(way, left) * left;
    const Vec3 begin = knee + 0.01125 / norm(level) * level;
    const Vec3 end = plate - 0.01125 / norm(level) * level;
    // of the rods the part of `left` that is square to them
    const Vec3 rod = (end - begin) / norm(end - begin);
    const Vec3 aside = left - dot(left, rod) * rod;
    sum += raised(g.links[0], motor, knee, left, up) +
           raised(g.links[1], begin, end, aside / norm(aside), up);
  }
  return sum;
}

/// True if its motors turn the handle.
bool turns(std::string_view driver) {
  return driver == "six motors" || driver == "own device";
}

/// The emulated device of a driver, with its load.
template <typename Bench, typename Options>
std::unique_ptr<DriverBench> opened(Options options, const SimulatedHandConfig& hand,
                                    PlantLoad load, const DeviceConfig& config) {
  options.hand = hand;
  options.load = std::move(load);
  return std::make_unique<Bench>(options, config);
}

std::unique_ptr<DriverBench> open_loaded(std::string_view driver, const SimulatedHandConfig& hand,
                                         PlantLoad load) {
  DeviceConfig config;
  config.max_force = config.max_torque = 100;
  if (driver == "falcon") return opened<FalconBench>(EmulatedFalconOptions{}, hand, load, config);
  if (driver == "haply") return opened<HaplyBench>(EmulatedHaplyOptions{}, hand, load, config);
  if (driver == "hid arm") return opened<HidArmBench>(EmulatedHidArmOptions{}, hand, load, config);
  EmulatedDeviceOptions options;
  if (driver == "polhem") options.arm = &polhem_arm();
  if (driver == "six motors") options.arm = &six_motors_arm();
  if (driver == "own device") options.arm = &own_device_arm();
  return opened<EmulatedArm>(options, hand, load, config);
}

/// Nobody's hand, about a handle that stands at a place.
SimulatedHandConfig nobody(const DriverRow& row, const Vec3& place_B) {
  SimulatedHandConfig hand = pressing(row, "none", 0);
  hand.intent.centre_B = place_B;
  hand.intent.tremor_amplitude = 0;
  hand.hand_damping = 1e-9;  // so that it begins there
  return hand;
}

}  // namespace

GravityConfig known_masses(std::string_view driver) {
  GravityConfig g;
  g.handle = {0.05, {}};
  if (driver == "falcon") {
    g.down_B = {0, -1, 0};
    g.handle.mass = 0.12;
    g.links = {{{0.02, {0.025, 0.001, 0.004}}, {0.015, {0.05, 0, 0.002}}, {}}};
  } else if (driver == "haply") {
    // its board upright: the plane is, too
    g.down_B = {0, -1, 0};
    g.links = {{{0.02, {0.02, 0.003, 0.01}}, {0.015, {0.04, 0.002, 0}}, {}}};
  } else if (driver == "polhem") {
    g.links = {{{0.12, {0.07, 0.01, 0.005}}, {0.09, {0.03, 0, -0.004}}, {0.03, {0.01, 0, 0}}}};
  } else if (driver != "own device") {
    g.links = {{{0.17, {0.051, 0.004, 0.006}}, {0.11, {0.091, 0, -0.005}}, {}}};
    if (driver == "six motors") g.handle.centre = {0.01, -0.005, 0.03};
  }
  return g;
}

GravityConfig times(double factor, GravityConfig g) {
  g.handle.mass *= factor;
  for (LinkMass& link : g.links) link.mass *= factor;
  return g;
}

double weight_energy(std::string_view driver, const GravityConfig& g, const Pose& X_BH) {
  const Vec3 up = g.down_B != Vec3{} ? -1.0 * g.down_B : Vec3{0, 0, 1};
  const Vec3 centre = turns(driver) ? g.handle.centre : Vec3{};
  double sum = g.handle.mass * dot(X_BH * centre, up);
  if (driver == "falcon") sum += falcon_moment(g, X_BH.p, up);
  if (driver == "haply") sum += haply_moment(g, X_BH.p, up);
  if (driver == "polhem") sum += polhem_moment(g, X_BH.p, up);
  if (driver == "hid arm" || driver == "woodenhaptics" || driver == "six motors") {
    sum += wooden_moment(g, X_BH.p, up);
  }
  return 9.81 * sum;
}

Wrench pull_of_weight(std::string_view driver, const GravityConfig& g, const Pose& X_BH) {
  constexpr double kWay = 1e-5, kTurn = 1e-4;  // [m], [rad]
  Wrench F_B;
  for (int i = 0; i < 3; ++i) {
    Vec3 way, turn;
    way[i] = kWay;
    turn[i] = kTurn;
    const auto moved = [&](const Vec3& by) {
      return weight_energy(driver, g, {X_BH.p + by, X_BH.q});
    };
    const auto turned = [&](const Vec3& by) {
      return weight_energy(driver, g, {X_BH.p, from_rotation_vector(by) * X_BH.q});
    };
    F_B.f[i] = (moved(-1.0 * way) - moved(way)) / (2 * kWay);
    if (turns(driver)) F_B.t[i] = (turned(-1.0 * turn) - turned(turn)) / (2 * kTurn);
  }
  return F_B;
}

WeighedArm::WeighedArm(const DriverRow& row, const GravityConfig& gravity, const Vec3& at_B)
    : place_B(at_B),
      driver_(row.name),
      gravity_(gravity),
      up_B_(gravity.down_B != Vec3{} ? -1.0 * gravity.down_B : Vec3{0, 0, 1}),
      bench_(open_loaded(row.name, nobody(row, at_B),
                         [this](const HandPlant& plant) { return load(plant); })) {}

Wrench WeighedArm::load(const HandPlant& plant) {
  constexpr double kWay = 5e-5, kTurn = 5e-4;    // of which the weight knows nothing: 1 mN
  constexpr double kHold = 2000, kHoldTurn = 2;  // [N/m], [N·m/rad]
  const Pose X_BH{plant.p_B, plant.q_B};
  // one that moves has its weight of 2 ms ago
  if (norm(X_BH.p - pulled_at_.p) > kWay + 2e-3 * norm(plant.v_B) ||
      norm(to_rotation_vector(X_BH.q * conjugate(pulled_at_.q))) > kTurn) {
    pull_B_ = pull_of_weight(driver_, gravity_, X_BH);
    pulled_at_ = X_BH;
  }
  Wrench F_B = pull_B_;
  if (is_held) {
    F_B.f += kHold * (place_B - X_BH.p) - 20.0 * plant.v_B;
    F_B.t += -kHoldTurn * to_rotation_vector(X_BH.q) - 0.01 * plant.w_B;
  }
  const double below = stand - dot(X_BH.p, up_B_);
  if (has_stand && below > 0) {
    // a cup, which keeps what lies in it
    const Vec3 off = X_BH.p - place_B;
    F_B.f += 1e4 * below * up_B_ - 1e3 * (off - dot(off, up_B_) * up_B_) - 20.0 * plant.v_B;
  }
  return F_B;
}

}  // namespace haptic::test
