// SPDX-License-Identifier: GPL-3.0-or-later
// The line of a Polhem: its bytes as the public library has them, and damaged ones.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>

#include "device-io/polhem/kinematics.h"
#include "device-io/woodenhaptics/protocol.h"
#include "tests/support/torture_scale.h"

using namespace haptic;

// forsslund/hfabapi (cf00e97), hfab_protocol.h: pc_to_device_message is "[%d,%d,%d]\n",
// device_to_pc_message "[%d,%d,%d,%d,%d,%d,%d,%d]\n" with the model first and the error last.
TEST_CASE("polhem line: as hfabapi has it", "[device-io]") {
  CHECK(encode_currents({1118, 910, -305}, Challenge::kNone, polhem_arm().motors).view() ==
        "[1118,910,-305]\n");
  ReplyReader reader;
  EncoderReply reply;
  bool whole = false;
  for (const char c : std::string("[1,-8312,6022,-8557,-29,128,-84,0]\n")) {
    whole |= reader.push(c, reply);
  }
  REQUIRE(whole);
  CHECK(reply.model == polhem_arm().model);
  CHECK(reply.counts == std::array<int32_t, 6>{-8312, 6022, -8557, -29, 128, -84});
  CHECK(reply.error == 0);
}

TEST_CASE("polhem line: fuzz: answers that are right, damaged, cut or doubled", "[device-io]") {
  // 10⁷: HAPTIC_TORTURE_SCALE=500, with a sanitizer 10000
  std::mt19937 random(23);
  ReplyReader reader;
  size_t heard = 0;
  const size_t n = test::sweep(20'000);
  const std::string likely = "[],-0123456789\n";
  for (size_t k = 0; k < n; ++k) {
    MotorCounts sent;
    std::string text = "[1";
    for (int32_t& count : sent) {
      count = static_cast<int32_t>(random()) >> (random() % 32);
      text += "," + std::to_string(count);
    }
    text += ",0]\n";
    const auto fate = random() % 8;
    const size_t at = random() % text.size();
    if (fate == 0) text[at] = static_cast<char>(random());
    if (fate == 1) text[at] = likely[random() % likely.size()];
    if (fate == 2) text.erase(at, 1 + random() % 3);
    if (fate == 3) text.insert(at, text.substr(0, random() % text.size()));
    EncoderReply reply;
    bool whole = false;
    for (const char c : text) {
      if (!reader.push(c, reply)) continue;
      whole = true;
      const JointAngles angles = polhem_arm().angles(reply.counts);
      const Pose X_BH = polhem_arm().pose(angles);
      const MotorAmperes amperes = polhem_arm().currents(angles, {{1, -2, 3}, {}});
      const bool finite = is_finite(X_BH.p) && std::fabs(dot(X_BH.q, X_BH.q) - 1) < 1e-9 &&
                          std::isfinite(amperes[0] + amperes[1] + amperes[2]);
      if (!finite) FAIL("input " << k << ": " << text);
    }
    heard += whole ? 1 : 0;
    if (fate > 3 && (!whole || reply.counts != sent)) FAIL("input " << k << ": " << text);
  }
  CHECK(heard > n / 2);
}
