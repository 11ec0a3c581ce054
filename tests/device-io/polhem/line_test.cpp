// SPDX-License-Identifier: GPL-3.0-or-later
// The line of a Polhem: its bytes as the public library has them.
#include <catch2/catch.hpp>
#include <string>

#include "device-io/polhem/kinematics.h"
#include "device-io/woodenhaptics/protocol.h"

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
