// SPDX-License-Identifier: GPL-3.0-or-later
// Arms of known masses are weighed through their bytes, on virtual time: on their stand, without a
// hand. The table that comes of it is judged by the weight of the arm in other places.
#include "clients/desk/trial/weighing.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "clients/desk/trial/guarded_hand.h"
#include "clients/desk/trial/trial_run.h"
#include "proto/config/devices.h"
#include "proto/math/units.h"
#include "tests/support/driver/known_weight.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// Masses with which every place of an arm takes less than 30 % of its force.
GravityConfig light_masses(const DriverRow& row) {
  const std::string_view name = row.name;
  return times(name == "haply" || name == "own device" ? 0.8 : 0.6, known_masses(name));
}

size_t links_of(const GravityConfig& gravity) {
  return static_cast<size_t>(
      std::ranges::count_if(gravity.links, [](const LinkMass& link) { return link.mass != 0; }));
}

/// An arm that is weighed as TrialRun does.
struct Weighed {
  const DriverRow& row;
  GravityConfig known = light_masses(row);
  WeighedArm arm;
  Weighing weighing;
  GuardedHand guard;
  DeviceState state{};
  int64_t t_ns = arm.device().t_ns(), begin_ns = t_ns;
  double noise = 0;  // of the motors' force, of its size, another in each 10 mm
  Wrench F_B;

  static SafetyLimits limits(const DriverRow& row) {
    SafetyLimits limits;
    limits.max_force = row.limits.force;
    limits.max_torque = row.limits.torque;
    return weighing_limits(limits);
  }
  static WeighPlan plan(const DriverRow& row, const GravityConfig& known) {
    WeighPlan plan;
    plan.centre_B = row.wall.at_B;
    plan.radius = row.is_flat ? 0.03 : 0.05;
    plan.is_planar = row.is_flat;
    plan.force = limits(row).max_force;
    plan.turning = row.limits.torque > 0 ? 0.2 : 0;
    plan.down_B = known.down_B;
    plan.n_links = links_of(known);
    return plan;
  }
  /// It lies on its stand, below all places.
  explicit Weighed(const DriverRow& of)
      : row(of),
        arm(row, known, rest()),
        weighing(plan(row, known),
                 [this](const GravityConfig& g) { return arm.device().holding(g); }),
        guard(limits(row), 1, 1) {
    arm.is_held = false;
    arm.stand = -dot(rest(), down()) - 1e-4;
    arm.has_stand = true;
  }
  Vec3 down() const { return known.down_B != Vec3{} ? known.down_B : Vec3{0, 0, -1}; }

  Vec3 rest() const { return row.wall.at_B + (row.is_flat ? 0.033 : 0.045) * down(); }

  bool is_over() const { return weighing.is_over() || guard.end() != TrialEnd::kNone; }
  void step() {
    t_ns += kMs;
    arm.device().read({t_ns, t_ns}, state);
    // let the device be heard first
    if (t_ns < begin_ns + 100 * kMs) return arm.device().write({});
    const double t = 1e-9 * static_cast<double>(t_ns - begin_ns);
    F_B = guard.tick(state, t_ns, weighing.wanted(state, t), kTick);
    weighing.note(state, F_B);
    arm.device().write((1 + noise * noise_at(state.X_BH.p)) * F_B);
  }
  /// Steps until it is over, or for so long.
  void run(double time = 200) {
    for (int i = 0; i < 1000 * time && !is_over(); ++i) step();
  }

  /// Until it has been through so many places.
  void run_through(size_t places) {
    while (!is_over() && weighing.places().size() < places) step();
    CAPTURE(row.name, state.X_BH.p, state.V_BH.v, F_B.f, weighing.places().size());
    REQUIRE(guard.end() == TrialEnd::kNone);
    REQUIRE(weighing.end() == WeighEnd::kNone);
  }

  /// Of size 1, in cells of 10 mm.
  static double noise_at(const Vec3& p_B) {
    const auto cell = [](double x) { return static_cast<uint32_t>(std::lround(x / 0.01) + 100); };
    std::minstd_rand random(1 + cell(p_B.x) + 300 * cell(p_B.y) + 90'000 * cell(p_B.z));
    random.discard(3);
    return std::normal_distribution<double>(0, 1)(random);
  }
  /// Of the weight that a table does not hold up, the most in places that were not weighed [N].
  double missing(const GravityConfig& table) {
    double most = 0;
    for (int n = 0; n < 20; ++n) {
      const double a = 0.7 * n, r = 0.4 * plan(row, known).radius;
      const Pose X_BH{row.wall.at_B + Vec3{r * std::cos(a), r * std::sin(a),
                                           row.is_flat ? 0 : r * std::sin(2.3 * a)},
                      {}};
      Vec3 off = pull_of_weight(row.name, known, X_BH).f - pull_of_weight(row.name, table, X_BH).f;
      if (row.is_flat) off.z = 0;
      most = std::max(most, norm(off));
    }
    return most;
  }
};

}  // namespace

TEST_CASE("weigh: the table of an arm holds it up, and its friction is found", "[device-io]") {
  const DriverRow row = GENERATE(from_range(driver_rows()));
  INFO(row.name);
  Weighed w(row);
  // some of its places tell enough; all of them: "weigh: all arms"
  w.run_through(3);
  const WeightFit fit = w.weighing.fit();
  const double missing = w.missing(fit.gravity);
  CAPTURE(fit.residual, fit.largest_residual, fit.most_weight, fit.friction, missing);
  CHECK(missing < 0.05 * fit.most_weight);
  CHECK(fit.residual < 0.01 * fit.most_weight);
  CHECK(fit.friction == Approx(row.body.friction).epsilon(0.05));
  CHECK(fit.most_weight > 0.3);
}

TEST_CASE("weigh: all arms in all places, measured", "[.weigh-all]") {
  const DriverRow row = GENERATE(from_range(driver_rows()));
  Weighed w(row);
  w.run_through(Weighing::kPlaces);
  w.run();
  const WeightFit fit = w.weighing.fit();
  const double missing = w.missing(fit.gravity);
  std::printf(
      "%s: %.0f s, %.2f to %.2f N, friction %.3f N of %.2f N, residual %.4f N, at most "
      "%.4f N, missing elsewhere %.4f N\n",
      row.name, 1e-9 * static_cast<double>(w.t_ns - w.begin_ns), fit.least_weight, fit.most_weight,
      fit.friction, row.body.friction, fit.residual, fit.largest_residual, missing);
  CHECK(missing < 0.01 * fit.most_weight);
  // it lies where it lay
  CHECK(norm(w.arm.device().plant().p_B - w.rest()) < 2e-3);
}

TEST_CASE("weigh: a residual tells of motors that are off by 5 %", "[device-io]") {
  Weighed w(driver_row("woodenhaptics"));
  w.noise = 0.05;
  w.run_through(Weighing::kPlaces);
  const WeightFit fit = w.weighing.fit();
  CAPTURE(fit.residual, fit.most_weight);
  CHECK(fit.residual > 0.02 * fit.least_weight);
  CHECK(fit.residual < 0.07 * fit.most_weight);
  CHECK(w.missing(fit.gravity) < 0.08 * fit.most_weight);
}

TEST_CASE("weigh: a touch ends it, and so does what is in the way", "[device-io]") {
  Weighed w(driver_row("woodenhaptics"));
  w.run(4);
  REQUIRE_FALSE(w.is_over());
  REQUIRE(w.F_B.f.z > 0.4);
  const Vec3 place_B = w.arm.device().plant().p_B;
  WeighEnd expected{};
  SECTION("a hand that takes it aside") {
    w.arm.is_held = true;
    for (int i = 1; i <= 100 && !w.is_over(); ++i) {
      w.arm.place_B = place_B + Vec3{0, -1e-4 * i, 0};
      w.step();
    }
    expected = WeighEnd::kUnasked;
  }
  SECTION("a hand that knocks at it") {
    w.arm.is_held = true;
    w.arm.place_B = place_B + Vec3{0, 0.01, 0.01};
    w.run(0.1);
    expected = WeighEnd::kTouched;
  }
  SECTION("a hand that holds it fast") {
    w.arm.is_held = true;
    w.arm.place_B = place_B;
    w.run(5);
    expected = WeighEnd::kLeftBehind;
  }
  CHECK(w.weighing.end() == expected);
  w.step();
  CHECK(w.F_B == Wrench{});
}

TEST_CASE("weigh: an arm that is too heavy is never pushed with more than 30 %", "[device-io]") {
  Weighed w(driver_row("woodenhaptics"));
  w.arm.is_held = true;  // as one that lies there
  w.arm.place_B = w.rest();
  double most = 0;
  for (int i = 0; i < 10'000 && !w.is_over(); ++i) {
    w.step();
    most = std::max(most, norm(w.F_B.f));
  }
  CHECK(w.weighing.end() == WeighEnd::kLeftBehind);
  CHECK(most == Approx(0.3 * w.row.limits.force));
}

TEST_CASE("weigh: the block that is pasted is the table that was found", "[device-io]") {
  constexpr const char* kNames[] = {"handle", "upper_arm", "forearm"};
  const std::vector<std::string_view> names(std::begin(kNames), std::end(kNames));
  GravityConfig table = known_masses("woodenhaptics");
  table.down_B = {0, -1, 0};
  table.links[1].mass = -0.0123;
  const std::string session =
      "[session]\nname = \"x\"\n[device]\nkind = \"woodenhaptics\"\n[device.serial]\npath = "
      "\"/dev/x\"\n" +
      gravity_block(table, names) + "[coupling]\nstiffness = \"500 N/m\"\n";
  const GravityConfig read = parse_config(session, "x.toml").device.gravity;
  CHECK(read.down_B == table.down_B);
  CHECK(read.handle.mass == Approx(table.handle.mass));
  for (size_t i = 0; i < 2; ++i) {
    CHECK(read.links[i].mass == Approx(table.links[i].mass));
    CHECK_THAT(read.links[i].centre, IsNear(table.links[i].centre, 1e-5));
  }
}
