// SPDX-License-Identifier: GPL-3.0-or-later
// Arms of known masses and friction behind their bytes, held up by the servo and let go of: driver,
// emulated device and the servo's step on virtual time.
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/driver/known_weight.h"
#include "tests/support/servo_tick.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// An arm that is led to places and let go of under the servo, which has a table of its masses.
class HeldUp {
 public:
  HeldUp(const DriverRow& row, const GravityConfig& table)
      : row_(row), table_(table), arm(row, known_masses(row.name), place()) {
    model_.limits.max_force = arm.device().caps().max_force;
    model_.limits.max_torque = arm.device().caps().max_torque;
    run(1050);
  }

  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      t_ns_ += kMs;
      ServoInput input = input_at(t_ns_ / kMs, {}, set_.get());
      arm.device().read({t_ns_, t_ns_}, input.device);
      input.holding_B = arm.device().holding(table_);
      frame = step_armed(model_, state_, input);
      seen |= frame.flags;
      arm.device().write(frame.F_device_B);
    }
  }
  /// Somebody leads it to another place, and holds it there.
  void lead() {
    arm.is_held = true;
    const Vec3 from_B = arm.place_B, to_B = place();
    for (int i = 1; i <= 300; ++i) {
      const double x = i / 300.0;
      arm.place_B = from_B + x * x * (3 - 2 * x) * (to_B - from_B);
      run(1);
    }
    run(60);
  }
  const Vec3& p_B() { return arm.device().plant().p_B; }

  ServoFrame frame;
  uint32_t seen = 0;

 private:
  Vec3 place() {
    std::uniform_real_distribution<double> u(-0.025, 0.025);
    Vec3 aside{u(random_), u(random_), u(random_)};
    if (row_.is_flat) aside = {aside.x, 0.4 * aside.y, 0};
    return row_.wall.at_B + aside;
  }

  std::minstd_rand random_{7};
  const DriverRow& row_;
  GravityConfig table_;
  ServoModel model_ = plain_model(500);
  ServoState state_;
  std::unique_ptr<ContactSet> set_ = set_of({});
  int64_t t_ns_ = DriverBench::kStartNs;

 public:
  WeighedArm arm;
};

/// What a unit of each motor makes at the handle, by the descriptions: 1 mA of 0.0259 N·m/A at a
/// ratio of 12 over 0.2 m of lever, 0.1 mN·m at 30 mm, 5 mN of the line; and one count of the pose.
constexpr double kUnit = 8e-3;  // [N]

}  // namespace

TEST_CASE("let go: an arm that is held up stays in twenty places", "[device-io]") {
  const DriverRow row = GENERATE(from_range(driver_rows()));
  INFO(row.name);
  HeldUp held(row, known_masses(row.name));
  double farthest = 0, missing = 0, weight = 0;
  for (int place = 0; place < 20; ++place) {
    held.lead();
    const Vec3 from_B = held.p_B();
    held.arm.is_held = false;
    held.run(60);
    farthest = std::max(farthest, norm(held.p_B() - from_B));
    missing = std::max(missing, norm(held.arm.device().felt_B().f + held.arm.pull_B().f));
    weight = std::max(weight, norm(held.arm.pull_B().f));
  }
  CAPTURE(farthest, missing, weight);
  // friction is larger than what the motors' step leaves, so nothing moves it at all
  CHECK(missing < 1.1 * kUnit);
  CHECK(farthest < 2e-6);
  CHECK(weight > 0.4);
  CHECK((held.seen & (kServoWeightEnded | kServoFault)) == 0);
  // without its table it falls
  HeldUp bare(row, {});
  const Vec3 from_B = bare.p_B();
  bare.arm.is_held = false;
  for (int i = 0; i < 200 && norm(bare.p_B() - from_B) < 5e-3; ++i) bare.run(1);
  CHECK(norm(bare.p_B() - from_B) >= 5e-3);
}

TEST_CASE("let go: one with a wrong table is let go of by the servo, too", "[device-io]") {
  const DriverRow row = GENERATE(from_range(driver_rows()));
  const double factor = GENERATE(-1.0, 3.0);
  INFO(row.name << " by " << factor);
  HeldUp held(row, times(factor, known_masses(row.name)));
  held.run(400);
  CHECK((held.seen & kServoWeightEnded) == 0);
  const Vec3 from_B = held.p_B();
  held.arm.is_held = false;
  int ticks = 0;
  for (; ticks < 200 && (held.seen & kServoWeightEnded) == 0; ++ticks) held.run(1);
  CHECK(ticks < 200);
  CHECK(norm(held.p_B() - from_B) < 25e-3);
  held.run(5);
  CHECK(norm(held.frame.F_device_B.f) == 0);
}
