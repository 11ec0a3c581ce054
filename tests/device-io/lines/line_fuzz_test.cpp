// SPDX-License-Identifier: GPL-3.0-or-later
// Damaged answers of each device that speaks lines of text, through its reader and its kinematics.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>

#include "device-io/owndevice/own_device_arm.h"
#include "device-io/polhem/kinematics.h"
#include "device-io/sixmotors/kinematics.h"
#include "device-io/woodenhaptics/kinematics.h"
#include "device-io/woodenhaptics/protocol.h"
#include "tests/support/torture_scale.h"

using namespace haptic;

namespace {

std::string answer_of(const Arm& arm, const MotorCounts& counts) {
  std::string text = "[" + std::to_string(arm.model);
  for (const int32_t count : counts) text += "," + std::to_string(count);
  return text + ",0]\n";
}

/// Damages three answers of eight for certain and one by a piece of itself.
void spoil(std::string& text, unsigned fate, std::mt19937& random) {
  static const std::string kLikely = "[],-0123456789\n";
  const size_t at = random() % text.size();
  if (fate == 0) text[at] = static_cast<char>(random());
  if (fate == 1) text[at] = kLikely[random() % kLikely.size()];
  if (fate == 2) text.erase(at, 1 + random() % 3);
  if (fate == 3) text.insert(at, text.substr(0, random() % text.size()));
}

/// A pose and currents are found for these counts, whatever they are.
bool is_finite_at(const Arm& arm, const MotorCounts& counts) {
  const JointAngles angles = arm.angles(counts);
  const Pose X_BH = arm.pose(angles);
  double sum = 0;
  MotorEfforts motors;
  arm.efforts(angles, X_BH, {{1, -2, 3}, {0.1, 0, -0.2}}, motors);
  for (const double a : motors) sum += a;
  return is_finite(X_BH.p) && std::fabs(dot(X_BH.q, X_BH.q) - 1) < 1e-9 && std::isfinite(sum);
}

/// Answers that were read.
size_t fuzz(const Arm& arm, size_t n) {
  std::mt19937 random(23);
  ReplyReader reader;
  size_t heard = 0;
  for (size_t k = 0; k < n; ++k) {
    MotorCounts sent;
    for (int32_t& count : sent) count = static_cast<int32_t>(random()) >> (random() % 32);
    std::string text = answer_of(arm, sent);
    const auto fate = random() % 8;
    spoil(text, static_cast<unsigned>(fate), random);
    EncoderReply reply;
    bool whole = false;
    for (const char c : text) {
      if (!reader.push(c, reply)) continue;
      whole = true;
      if (!is_finite_at(arm, reply.counts)) FAIL("input " << k << ": " << text);
    }
    heard += whole ? 1 : 0;
    if (fate > 3 && (!whole || reply.counts != sent)) FAIL("input " << k << ": " << text);
  }
  return heard;
}

}  // namespace

// 10⁷ each: HAPTIC_TORTURE_SCALE=500, with a sanitizer 10000
TEST_CASE("lines: fuzz: answers of a WoodenHaptics", "[device-io][fuzz]") {
  const size_t n = test::sweep(20'000);
  CHECK(fuzz(woodenhaptics_arm(), n) > n / 2);
}

TEST_CASE("lines: fuzz: answers of a device with six motors", "[device-io][fuzz]") {
  const size_t n = test::sweep(20'000);
  CHECK(fuzz(six_motors_arm(), n) > n / 2);
}

TEST_CASE("lines: fuzz: answers of a device of your own", "[device-io][fuzz]") {
  const size_t n = test::sweep(20'000);
  CHECK(fuzz(own_device_arm(), n) > n / 2);
}

TEST_CASE("lines: fuzz: answers of a Polhem", "[device-io][fuzz]") {
  const size_t n = test::sweep(20'000);
  CHECK(fuzz(polhem_arm(), n) > n / 2);
}
