// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/safety.cpp.
#include "servo/safety.h"

#include <limits>

#include "tests/support/near.h"

using haptic::SafetyInput;
using haptic::SafetyLimits;
using haptic::SafetyOutput;
using haptic::SafetyState;
using haptic::Vec3;
using haptic::Wrench;
using haptic::test::IsNear;

namespace {

constexpr double kDt = 1e-3;
const SafetyLimits kLimits{5, 0.1, 0};
const double kNaN = std::numeric_limits<double>::quiet_NaN();
const double kInfinity = std::numeric_limits<double>::infinity();

SafetyState warm() {
  SafetyState state;
  state.gain = 1;
  return state;
}
SafetyInput asking(const Wrench& F_B) {
  SafetyInput input;
  input.F_B = F_B;
  return input;
}

}  // namespace

TEST_CASE("safety: a wrench within the limits passes unchanged", "[servo]") {
  SafetyState state = warm();
  const Wrench F{{1, -2, 3}, {0.01, 0.02, 0.03}};
  const SafetyOutput out = make_safe(kLimits, state, asking(F), kDt);
  CHECK(out.F_B == F);
  CHECK(out.flags == 0);
}

TEST_CASE("safety: saturation keeps the direction", "[servo]") {
  SafetyState state = warm();
  const Vec3 big{30, -40, 120};
  const SafetyOutput out = make_safe(kLimits, state, asking({big, {0, 0.3, 0.4}}), kDt);
  CHECK_THAT(out.F_B.f, IsNear(5.0 / 130 * big, 1e-12));
  CHECK_THAT(out.F_B.t, IsNear({0, 0.06, 0.08}, 1e-12));
  CHECK((out.flags & haptic::kServoSaturated) != 0);
}

TEST_CASE("safety: a saturated force is not above the limit by a single bit", "[servo]") {
  SafetyState state = warm();
  uint64_t seed = 3;
  auto uniform = [&] {
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(seed >> 11) * 0x1p-52 - 1;
  };
  for (int i = 0; i < 100000; ++i) {
    const Vec3 f = 50 * Vec3{uniform(), uniform(), uniform()};
    REQUIRE(norm(make_safe(kLimits, state, asking({f, {}}), kDt).F_B.f) <= kLimits.max_force);
  }
}

TEST_CASE("safety: a huge finite force is saturated, not a fault", "[servo]") {
  SafetyState state = warm();
  const double huge = 1e300;
  const SafetyOutput out = make_safe(kLimits, state, asking({{huge, 0, -huge}, {}}), kDt);
  CHECK_THAT(out.F_B.f, IsNear({5 / std::sqrt(2.0), 0, -5 / std::sqrt(2.0)}, 1e-12));
}

TEST_CASE("safety: NaN and infinity latch a fault until it is cleared", "[servo]") {
  const Vec3 bad = GENERATE(Vec3{std::numeric_limits<double>::quiet_NaN(), 0, 0},
                            Vec3{0, std::numeric_limits<double>::infinity(), 0});
  SafetyState state = warm();
  SafetyOutput out = make_safe(kLimits, state, asking({bad, {}}), kDt);
  CHECK(out.F_B == Wrench{});
  CHECK((out.flags & haptic::kServoFault) != 0);

  // a good wrench afterwards stays zero
  out = make_safe(kLimits, state, asking({{1, 0, 0}, {}}), kDt);
  CHECK(out.F_B == Wrench{});

  // cleared once: force again, from zero
  SafetyInput cleared = asking({{1, 0, 0}, {}});
  cleared.fault_clears = 1;
  SafetyLimits ramped = kLimits;
  ramped.soft_start = 0.1;
  out = make_safe(ramped, state, cleared, kDt);
  CHECK((out.flags & haptic::kServoFault) == 0);
  CHECK(norm(out.F_B.f) == 0);
  for (int i = 0; i < 101; ++i) out = make_safe(ramped, state, cleared, kDt);
  CHECK_THAT(out.F_B.f, IsNear({1, 0, 0}, 1e-12));
}

TEST_CASE("safety: a bad torque faults too", "[servo]") {
  SafetyState state = warm();
  const SafetyOutput nan = make_safe(kLimits, state, asking({{}, {0, 0, kNaN}}), kDt);
  CHECK((nan.flags & haptic::kServoFault) != 0);
  state = warm();
  const SafetyOutput inf = make_safe(kLimits, state, asking({{}, {-kInfinity, 0, 0}}), kDt);
  CHECK(inf.F_B == Wrench{});
}

TEST_CASE("safety: soft start rises linearly from zero and never steps", "[servo]") {
  SafetyState state;
  SafetyLimits limits = kLimits;
  limits.soft_start = 0.5;
  double before = 0;
  for (int k = 0; k <= 600; ++k) {
    const SafetyOutput out = make_safe(limits, state, asking({{0, 0, 4}, {}}), kDt);
    CHECK(out.F_B.f.z == Approx(4 * std::min(1.0, k * kDt / 0.5)).margin(1e-12));
    CHECK(out.F_B.f.z - before <= 4 * kDt / 0.5 + 1e-12);
    before = out.F_B.f.z;
  }
}

TEST_CASE("safety: closing the force zeroes it and opens through the soft start", "[servo]") {
  SafetyState state = warm();
  SafetyLimits limits = kLimits;
  limits.soft_start = 0.5;
  SafetyInput input = asking({{0, 0, 4}, {}});
  input.force_closed = true;
  CHECK(make_safe(limits, state, input, kDt).F_B == Wrench{});
  input.force_closed = false;
  CHECK(make_safe(limits, state, input, kDt).F_B.f.z <= 4 * kDt / 0.5);
}

TEST_CASE("safety: a device without torque motors drops the torque and says so", "[servo]") {
  SafetyState state = warm();
  SafetyLimits limits = kLimits;
  limits.max_torque = 0;
  const SafetyOutput out = make_safe(limits, state, asking({{1, 0, 0}, {0, 0, 0.02}}), kDt);
  CHECK(out.F_B.t == Vec3{});
  CHECK_THAT(out.F_B.f, IsNear({1, 0, 0}, 1e-15));
  CHECK((out.flags & haptic::kServoTorqueDropped) != 0);
  CHECK((out.flags & haptic::kServoSaturated) == 0);
}
