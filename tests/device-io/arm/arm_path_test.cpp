// SPDX-License-Identifier: GPL-3.0-or-later
// The path of a commanded arm, against straight lines written out.
#include "device-io/arm/arm_path.h"

#include "proto/math/units.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

Pose at_x(double x) {
  return {{x, 0, 0}, {}};
}

}  // namespace

TEST_CASE("arm path: straight from command to command, and at rest after the last", "[device]") {
  ArmPath path(0);
  path.rest_at(at_x(1));
  CHECK(path.at(-5 * kMs) == at_x(1));
  CHECK(path.at(5 * kMs) == at_x(1));
  path.go(10 * kMs, 11 * kMs, at_x(2));
  CHECK(path.at(10 * kMs).p.x == 1);
  CHECK(path.at(10 * kMs + kMs / 4).p.x == Approx(1.25));
  CHECK(path.at(11 * kMs).p.x == 2);
  CHECK(path.at(13 * kMs).p.x == 2);
  path.go(13 * kMs, 14 * kMs, at_x(0));
  CHECK(path.at(12 * kMs).p.x == 2);
  CHECK(path.at(13 * kMs + kMs / 2).p.x == Approx(1));
}

TEST_CASE("arm path: a command that comes early leaves from where the arm then is", "[device]") {
  ArmPath path(0);
  path.rest_at(at_x(0));
  path.go(0, 4 * kMs, at_x(4));
  path.go(kMs, 3 * kMs, at_x(0));
  CHECK(path.at(kMs / 2).p.x == Approx(0.5));
  CHECK(path.at(kMs).p.x == Approx(1));
  CHECK(path.at(2 * kMs).p.x == Approx(0.5));
  CHECK(path.at(9 * kMs).p.x == 0);
}

TEST_CASE("arm path: all of it later by the delay, over as many commands as are kept", "[device]") {
  constexpr int64_t kDelay = 50 * kMs, kTick = 100'000;  // the longest delay at 10 kHz
  ArmPath path(kDelay);
  path.rest_at(at_x(0));
  for (int k = 0; k < 5000; ++k) {
    const int64_t now = k * kTick;
    path.go(now, now + kTick, at_x(k + 1));
    const double then = static_cast<double>(now - kDelay) / kTick;
    REQUIRE(path.at(now).p.x == Approx(std::max(then, 0.0)).margin(1e-9));
  }
}

TEST_CASE("arm path: it turns at a constant rate", "[device]") {
  ArmPath path(0);
  path.rest_at({});
  path.go(0, kMs, {{}, from_rotation_vector({0, 0.4, 0})});
  CHECK_THAT(to_rotation_vector(path.at(kMs / 4).q), IsNear({0, 0.1, 0}, 1e-12));
}

TEST_CASE("arm path: rest gives up what was still to come", "[device]") {
  ArmPath path(2 * kMs);
  path.rest_at(at_x(0));
  path.go(kMs, 2 * kMs, at_x(1));
  path.rest_at(at_x(7));
  CHECK(path.at(3 * kMs).p.x == 7);
}
