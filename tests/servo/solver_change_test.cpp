// SPDX-License-Identifier: GPL-3.0-or-later
// A change of the solver of a soft body under a pressed hand.
#include <algorithm>
#include <memory>

#include "proto/math/units.h"
#include "proto/wire/renderer.h"
#include "tests/support/servo_tick.h"

using haptic::ContactSet;
using haptic::ControlFrame;
using haptic::kMs;
using haptic::Renderer;
using haptic::ServoFrame;
using haptic::ServoInput;
using haptic::ServoModel;
using haptic::ServoState;
using haptic::SoftSolver;
using haptic::Vec3;
using haptic::test::input_at;
using haptic::test::plain_model;
using haptic::test::plane;
using haptic::test::set_of;

namespace {

constexpr double kCoupling = 800, kWall = 3000;  // [N/m]
constexpr double kSlew = 2000;                   // [N/s]

/// A soft wall below z = 0, and a hand that stays in it from tick to tick.
class Pressed {
 public:
  ServoFrame frame{};
  ControlFrame control{};

  explicit Pressed(SoftSolver solver, Renderer renderer = Renderer::kVoxel)
      : model_(plain_model(kCoupling)), set_(set_of({plane({0, 0, 1}, {})})) {
    model_.limits.max_force = 8;
    model_.limits.slew = kSlew;
    model_.limits.soft_start = 0.5;
    control.armed = 1;
    control.translational_stiffness = kCoupling;
    control.solver = number_of(solver);
    set_->renderer = static_cast<uint32_t>(renderer);
    set_->contacts[0].stiffness = kWall;
    set_->tool = {0.1, {1e-4, 1e-4, 1e-4}, {}, 0.02};
  }

  /// Returns the change of the force.
  double tick(double depth) {
    ++tick_;
    set_->seq = static_cast<uint64_t>(tick_);
    set_->answers_t_ns = (tick_ - 1) * kMs;
    ServoInput input = input_at(tick_, {0, 0, -depth}, set_.get());
    input.control = &control;
    const Vec3 before_B = frame.F_device_B.f;
    frame = servo_step(model_, state_, input);
    return norm(frame.F_device_B.f - before_B);
  }

  /// Largest change of the force over so many ticks.
  double press(double depth, int ticks, double speed = 0) {
    double largest = 0;
    for (int k = 0; k < ticks; ++k) largest = std::max(largest, tick(depth + 1e-3 * speed * k));
    return largest;
  }

 private:
  ServoModel model_;
  std::unique_ptr<ContactSet> set_;
  ServoState state_;
  int64_t tick_ = 0;
};

double stiffness_of(SoftSolver solver) {
  return solver == SoftSolver::kDirect ? kWall : kCoupling * kWall / (kCoupling + kWall);
}

constexpr SoftSolver kDirect = SoftSolver::kDirect, kDynamics = SoftSolver::kPenaltyDynamics,
                     kStatic = SoftSolver::kQuasiStatic;

}  // namespace

TEST_CASE("solver change: under a resting hand the force changes no faster than slew allows",
          "[servo]") {
  const SoftSolver from = GENERATE(kDirect, kDynamics, kStatic);
  const SoftSolver to = GENERATE(kDirect, kDynamics, kStatic);
  // in the second the force that direct wants is fifteen times the limit
  const double depth = GENERATE(1e-3, 40e-3);
  CAPTURE(from, to, depth);
  Pressed hand(from);
  hand.press(depth, 2000);
  const double felt = std::min(stiffness_of(from) * depth, 8.0);
  CHECK(hand.frame.F_device_B.f.z == Approx(felt).epsilon(1e-3));
  hand.control.solver = number_of(to);
  double largest = 0;
  bool was_zero = false;
  for (int k = 0; k < 2000; ++k) {
    largest = std::max(largest, hand.tick(depth));
    was_zero |= hand.frame.F_device_B.f == Vec3{};
  }
  CHECK(largest <= kSlew * 1e-3 * (1 + 1e-9));
  // through zero, and then what the other one makes of the wall
  CHECK(was_zero == (from != to));
  CHECK((hand.frame.flags & haptic::kServoSoftStart) == 0);
  const double after = std::min(stiffness_of(to) * depth, 8.0);
  CHECK(hand.frame.F_device_B.f.z == Approx(after).epsilon(1e-3));
}

TEST_CASE("solver change: while the hand moves, its motion comes in addition", "[servo]") {
  const SoftSolver from = GENERATE(kDirect, kDynamics, kStatic);
  const SoftSolver to = GENERATE(kDirect, kDynamics, kStatic);
  CAPTURE(from, to);
  const double speed = 2e-3;
  Pressed hand(from);
  hand.press(1e-3, 1500);
  hand.control.solver = number_of(to);
  const double largest = hand.press(1e-3, 1000, speed);
  CHECK(largest <= kSlew * 1e-3 + kWall * speed * 1e-3);
}

TEST_CASE("solver change: a wish that is taken back before the force is zero changes nothing",
          "[servo]") {
  Pressed hand(SoftSolver::kQuasiStatic);
  hand.press(1e-3, 2000);
  hand.control.solver = number_of(SoftSolver::kDirect);
  hand.press(1e-3, 10);
  CHECK(hand.frame.F_device_B.f.z > 0);
  CHECK(hand.frame.F_device_B.f.z < 0.9 * stiffness_of(SoftSolver::kQuasiStatic) * 1e-3);
  hand.control.solver = number_of(SoftSolver::kQuasiStatic);
  CHECK(hand.press(1e-3, 1000) < 0.1);
  CHECK(hand.frame.F_device_B.f.z ==
        Approx(stiffness_of(SoftSolver::kQuasiStatic) * 1e-3).epsilon(1e-3));
}

TEST_CASE("solver change: a number that names no solver leaves the session's", "[servo]") {
  Pressed hand(SoftSolver::kDirect);
  hand.control.solver = 4;
  hand.press(1e-3, 1500);
  CHECK(hand.frame.F_device_B.f.z ==
        Approx(stiffness_of(SoftSolver::kQuasiStatic) * 1e-3).epsilon(1e-3));
}

TEST_CASE("solver change: a renderer of a point does not notice", "[servo]") {
  Pressed hand(SoftSolver::kDirect, Renderer::kGodObject3);
  hand.press(1e-3, 1500);
  const double felt = hand.frame.F_device_B.f.z;
  CHECK(felt == Approx(kCoupling * 1e-3));
  hand.control.solver = number_of(SoftSolver::kQuasiStatic);
  CHECK(hand.press(1e-3, 100) == 0);
}
