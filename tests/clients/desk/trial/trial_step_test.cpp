// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for clients/desk/trial: the steps of a trial on a handle that is a mass on a hand's spring,
// on virtual time.
#include "clients/desk/trial/trial_step.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "proto/math/quat.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr int64_t kBegin_ns = 1'000'000'000;  // of the virtual clock
constexpr uint32_t kReady = kDeviceFresh | kDeviceHomed;

SafetyLimits limits_of(double force, double torque = 0) {
  SafetyLimits limits;
  limits.max_force = force;
  limits.max_torque = torque;
  return limits;
}

/// A handle in a hand: m x'' = F − k x − b x' in each direction, and likewise about each axis.
struct Handle {
  double stiffness = 300, damping = 10, mass = 0.5;  // [N/m], [N·s/m], [kg]
  double sign = 1;                                   // −1: a motor that is wired the wrong way
  std::function<double(double t)> hand = [](double) { return 0.0; };  // where it means to be [m]
  Vec3 x{0.01, 0.02, 0.03}, rest{0.01, 0.02, 0.03}, v{}, turn{}, turning{};

  void step(const Wrench& F, double t) {
    const Vec3 aim = rest + Vec3{hand(t), hand(t), hand(t)};
    v += (kTick / mass) * (sign * F.f - stiffness * (x - aim) - damping * v);
    x += kTick * v;
    // 1 N·m/rad, critically damped at 1e-3 kg·m²
    turning += (kTick / 1e-3) * (sign * F.t - turn - 0.06 * turning);
    turn += kTick * turning;
  }
  DeviceState state(double t) const {
    DeviceState device{};
    device.t_ns = kBegin_ns + std::llround(1e9 * t);
    device.X_BH = {x, from_rotation_vector(turn)};
    device.V_BH = {v, turning};
    device.flags = kReady;
    return device;
  }
};

/// Pushes the handle as TrialRun does; returns the rows, and the largest wrench commanded.
std::vector<TrialRow> push(Handle& handle, const SafetyLimits& limits, Wrench* most = nullptr,
                           TrialEnd* end = nullptr) {
  GuardedHand guard(limits, 0.05);
  PushStep step(guard.limits());
  for (int i = 0; i * kTick < step.time() && guard.end() == TrialEnd::kNone; ++i) {
    const double t = i * kTick;
    const DeviceState device = handle.state(t);
    const Wrench F = guard.tick(device, device.t_ns, step.wanted(t), kTick);
    step.note(device, t);
    handle.step(F, t);
    if (most != nullptr && norm(F.f) > most->f.x) most->f.x = norm(F.f);
    if (most != nullptr && norm(F.t) > most->t.x) most->t.x = norm(F.t);
  }
  if (end != nullptr) *end = guard.end();
  return step.rows();
}

int count(const std::vector<TrialRow>& rows, Verdict verdict) {
  return static_cast<int>(std::count_if(
      rows.begin(), rows.end(), [&](const TrialRow& row) { return row.verdict == verdict; }));
}

}  // namespace

TEST_CASE("trial: each axis that pushes the right way passes, with 5 % of the force at most") {
  Handle handle;
  Wrench most;
  const auto rows = push(handle, limits_of(8, 0.2), &most);
  REQUIRE(rows.size() == 6);
  CHECK(count(rows, Verdict::kPassed) == 6);
  CHECK(most.f.x <= 0.05 * 8 + 1e-12);
  CHECK(most.f.x > 0.99 * 0.05 * 8);
  CHECK(most.t.x <= 0.05 * 0.2 + 1e-12);
  // the spring's answer: F/k = 0.4 N / 300 N/m, and 10 mN·m at 1 N·m/rad
  CHECK(rows[0].measured == "the handle went +1.33 mm with it");
  CHECK(rows[3].measured == "the handle turned +10.0 mrad with it");
  CHECK(push(handle, limits_of(8)).size() == 3);
}

TEST_CASE("trial: a motor that is wired the wrong way fails") {
  Handle handle{.sign = -1};
  CHECK(count(push(handle, limits_of(8)), Verdict::kFailed) == 3);
}

TEST_CASE("trial: a handle that cannot move leaves it open") {
  Handle handle{.stiffness = 20'000, .damping = 100};
  CHECK(count(push(handle, limits_of(8)), Verdict::kUnclear) == 3);
}

TEST_CASE("trial: drift and tremor of the hand are not taken for the push") {
  const double sign = GENERATE(1, -1, 0);
  Handle handle{.sign = sign};
  // 0.5 mm/s, and 0.15 mm at 9 Hz
  handle.hand = [](double t) { return 5e-4 * t + 1.5e-4 * std::sin(2 * std::numbers::pi * 9 * t); };
  const Verdict verdict = sign > 0   ? Verdict::kPassed
                          : sign < 0 ? Verdict::kFailed
                                     : Verdict::kUnclear;
  CHECK(count(push(handle, limits_of(8)), verdict) == 3);
}

TEST_CASE("trial: what a hand does not hold ends the push, and nothing more is commanded") {
  Handle free{.stiffness = 0, .damping = 0, .mass = 0.1};
  TrialEnd end = TrialEnd::kNone;
  const auto rows = push(free, limits_of(8), nullptr, &end);
  CHECK((end == TrialEnd::kTooFast || end == TrialEnd::kTooFar));
  CHECK(rows[2].verdict == Verdict::kUnclear);
  CHECK(rows[2].measured == "not reached");

  GuardedHand guard(limits_of(8), 0.5);
  Handle handle;
  const auto told = [&](double t, uint32_t flags, double x) {
    handle.x.x = x;
    DeviceState device = handle.state(t);
    device.flags = flags;
    return norm(guard.tick(device, device.t_ns, {{2, 0, 0}, {}}, kTick).f);
  };
  double t = 0, force = 0;
  for (; t < 0.5; t += kTick) force = told(t, kReady, 0.01);
  CHECK(force == Approx(2));
  // slowly out of reach
  for (double x = 0.01; x < 0.1; x += 1e-4, t += kTick) force = told(t, kReady, x);
  CHECK(guard.end() == TrialEnd::kTooFar);
  CHECK(force == 0);
  // nor when the hand has brought it back
  for (double x = 0.0995; x > 0.01; x -= 1e-4, t += kTick) CHECK(told(t, kReady, x) == 0);
}

TEST_CASE("trial: a device that goes silent, noisy, mad or unhomed gets no force any more") {
  const uint32_t flags = GENERATE(values<uint32_t>(
      {kReady, kReady | kDeviceLost, kReady | kDeviceStale, kReady | kDeviceNoisy, kDeviceFresh}));
  GuardedHand guard(limits_of(8), 1);
  Handle handle;
  double t = 0;
  Wrench F;
  for (; t < 1; t += kTick)
    F = guard.tick(handle.state(t), handle.state(t).t_ns, {{1, 0, 0}, {}}, kTick);
  CHECK(norm(F.f) == Approx(1));
  CAPTURE(flags);
  DeviceState bad = handle.state(t);
  bad.flags = flags;
  if (flags == kReady) bad.X_BH.p.x = std::numeric_limits<double>::quiet_NaN();
  // at once without force; what is lost for a moment only may come back
  CHECK(norm(guard.tick(bad, bad.t_ns, {{1, 0, 0}, {}}, kTick).f) == 0);
  const bool is_fault = flags != (kReady | kDeviceLost) && flags != kDeviceFresh;
  CHECK(guard.end() == (is_fault ? TrialEnd::kFault : TrialEnd::kNone));
  for (int i = 1; i < 110; ++i) {
    bad.t_ns += 1'000'000;
    CHECK(norm(guard.tick(bad, bad.t_ns, {{1, 0, 0}, {}}, kTick).f) == 0);
  }
  CHECK(guard.end() == (is_fault ? TrialEnd::kFault : TrialEnd::kLost));
}

TEST_CASE("trial: while looking nothing is commanded, whatever is wanted") {
  GuardedHand guard(limits_of(8), 0);
  Handle handle;
  for (double t = 0; t < 0.5; t += kTick) {
    const DeviceState device = handle.state(t);
    CHECK(norm(guard.tick(device, device.t_ns, {{8, 0, 0}, {}}, kTick).f) == 0);
  }
  CHECK(guard.end() == TrialEnd::kNone);
}

TEST_CASE("trial: looking tells a good device from one that is silent, unhomed or in doubt") {
  const auto looked = [](const std::function<void(DeviceState&, double)>& spoil) {
    LookStep look;
    for (double t = 0; t < LookStep::kTime; t += kTick) {
      Handle handle;
      handle.x.y = 0.02 + 0.03 * std::sin(t);
      DeviceState device = handle.state(t);
      spoil(device, t);
      look.note(device, t);
    }
    return look.rows();
  };
  const auto good = looked([](DeviceState&, double) {});
  REQUIRE(good.size() == 6);
  CHECK(count(good, Verdict::kPassed) == 6);
  CHECK(good[0].measured == "1000 samples a second");
  CHECK(good[4].measured == "x 0 mm, y 60 mm, z 0 mm");

  const auto silent = looked([](DeviceState& d, double t) {
    if (t > 2 && t < 2.2) d.flags = kDeviceHeld | kDeviceHomed;
  });
  CHECK(silent[1].verdict == Verdict::kFailed);
  CHECK(looked([](DeviceState& d, double) { d.flags = kDeviceLost; })[0].verdict ==
        Verdict::kFailed);
  CHECK(looked([](DeviceState& d, double t) {
          if (t > 1 && t < 1.01) d.flags |= kDeviceNoisy;
        })[2]
            .verdict == Verdict::kFailed);
  CHECK(looked([](DeviceState& d, double) { d.flags = kDeviceFresh; })[3].verdict ==
        Verdict::kFailed);
  CHECK(looked([](DeviceState& d, double) { d.X_BH.p = {}; })[4].verdict == Verdict::kUnclear);
}

TEST_CASE("trial: the full force is reached against a hand that holds, and only then") {
  const auto full = [](Handle handle) {
    GuardedHand guard(limits_of(4), 1);
    FullStep step(guard.limits());
    double most = 0;
    for (double t = 0; t < FullStep::kTime && guard.end() == TrialEnd::kNone; t += kTick) {
      const DeviceState device = handle.state(t);
      const Wrench F = guard.tick(device, device.t_ns, step.wanted(device, t), kTick);
      step.note(device, F, t);
      handle.step(F, t);
      most = std::max(most, norm(F.f));
    }
    CHECK(most <= 4 + 1e-9);
    return step.rows().front();
  };
  CHECK(full({}).verdict == Verdict::kPassed);
  CHECK(full({}).measured == "4.00 N of 4.00 N");
  CHECK(full({.stiffness = 20}).verdict == Verdict::kFailed);
}

}  // namespace haptic
