// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/pace.h"

#include <catch2/catch.hpp>

#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr double kSimPeriod = 1e-3;  // [s]

/// The flags that are set after `seconds` at 1 kHz, in which of each 100 ticks so many are skipped,
/// and have late contacts, and sim publishes so many frames.
uint32_t said_after(int seconds, int skipped, int late, int frames) {
  Pace pace;
  ServoInput input;
  SceneFrame scene{};
  scene.seq = 1;
  input.scene = &scene;
  uint32_t said = 0;
  for (int i = 0; i < 1000 * seconds; ++i) {
    const int of_100 = i % 100;
    if (of_100 < frames) ++scene.seq;
    if (of_100 < skipped) {
      ++input.skipped;
      continue;
    }
    input.t_ns = 5 * kNsPerSecond + i * kNsPerSecond / 1000;
    said = keep_pace(pace, input, of_100 >= 100 - late ? kServoHolding : 0u, kSimPeriod);
  }
  return said;
}

}  // namespace

TEST_CASE("pace: only processes that fall behind are reported, after a second") {
  CHECK(said_after(3, 0, 0, 100) == 0);
  CHECK(said_after(3, 1, 0, 91) == 0);
  CHECK(said_after(3, 0, 1, 91) == 0);
  CHECK(said_after(3, 2, 0, 100) == kServoLate);
  CHECK(said_after(3, 0, 2, 100) == kServoContactLate);
  CHECK(said_after(3, 0, 0, 89) == kServoSimLate);
  CHECK(said_after(3, 5, 5, 50) == (kServoLate | kServoContactLate | kServoSimLate));
  CHECK(said_after(1, 5, 5, 50) == 0);
}

TEST_CASE("pace: a sim that does not run, or began anew, is not late") {
  CHECK(said_after(3, 0, 0, 0) == 0);
  Pace pace;
  ServoInput input;
  CHECK(keep_pace(pace, input, 0, kSimPeriod) == 0);
  SceneFrame scene{};
  scene.seq = 900'000;
  input.scene = &scene;
  input.t_ns = 2 * kNsPerSecond;
  CHECK(keep_pace(pace, input, 0, kSimPeriod) == 0);
  scene.seq = 3;
  input.t_ns = 4 * kNsPerSecond;
  CHECK(keep_pace(pace, input, 0, kSimPeriod) == 0);
}

}  // namespace haptic
