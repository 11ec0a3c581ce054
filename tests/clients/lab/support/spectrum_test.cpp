// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for clients/lab/support/spectrum.cpp, against sines of known frequency.
#include "clients/lab/support/spectrum.h"

#include <numbers>
#include <vector>

#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

std::vector<Vec3> sine(double hertz, double amplitude, size_t n = 4000) {
  std::vector<Vec3> force;
  for (size_t i = 0; i < n; ++i) {
    force.push_back(
        {0, amplitude * std::sin(2 * std::numbers::pi * hertz * static_cast<double>(i) / 1000), 1});
  }
  return force;
}

}  // namespace

TEST_CASE("spectrum: a sine counts above its frequency, a constant never", "[lab]") {
  CHECK(rms_above(sine(200, 3), 1000, 100) == Approx(3 / std::sqrt(2)).epsilon(1e-3));
  CHECK(rms_above(sine(50, 3), 1000, 100) < 1e-6);
  CHECK(rms_above(sine(50, 3), 1000, 20) == Approx(3 / std::sqrt(2)).epsilon(1e-3));
  CHECK(rms_above(sine(0, 3), 1000, 1) < 1e-6);
  CHECK(rms_above({}, 1000, 100) == 0);
}

TEST_CASE("spectrum: a step counts more than a ramp of ten milliseconds", "[lab]") {
  std::vector<Vec3> step(4000), ramp(4000);
  for (size_t i = 2000; i < 4000; ++i) {
    step[i].x = 1;
    ramp[i].x = std::min(1.0, static_cast<double>(i - 2000) / 10);
  }
  CHECK(rms_above(step, 1000, 100) > 3 * rms_above(ramp, 1000, 100));
}
