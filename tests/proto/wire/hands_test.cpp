// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/wire/hands.h"

#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "proto/ipc/channels.h"
#include "proto/log/trace.h"

using namespace haptic;

TEST_CASE("what belongs to a hand is named and numbered by the hand", "[wire][hands]") {
  CHECK(std::string(servo_name(0)) == "servo0");
  CHECK(std::string(contact_name(1)) == "contact1");
  CHECK(servo_topic(0).name == "/servo0/frame");
  CHECK(contact_topic(1).name == "/contact1/set");
  CHECK(servo_segment(0) == SegmentId{2});
  CHECK(contact_segment(0) == SegmentId{3});
  CHECK(servo_segment(1) == SegmentId{0x12});
  CHECK(contact_segment(1) == SegmentId{0x13});

  CHECK(control_segment(0) == SegmentId{1});
  CHECK(control_segment(1) == SegmentId{0x11});
  CHECK(control_topic(0).name == "/control/frame");
  CHECK(control_topic(1).name == "/control1/frame");
  CHECK(find_topic("/control3/frame") != nullptr);

  std::set<SegmentId> ids{SegmentId::kSim};
  for (uint32_t hand = 0; hand < kMostHands; ++hand) {
    ids.insert({control_segment(hand), servo_segment(hand), contact_segment(hand)});
  }
  CHECK(ids.size() == 1 + 3 * kMostHands);
}
