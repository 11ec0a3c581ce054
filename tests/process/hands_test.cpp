// SPDX-License-Identifier: GPL-3.0-or-later
// Sessions of two hands: each is safe by itself.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "proto/ipc/control_socket.h"
#include "proto/log/trace.h"
#include "proto/os/json.h"
#include "tests/process/hapt_command.h"
#include "tests/process/hapticd_process.h"
#include "tests/process/watcher.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using namespace test;

/// A session of two hands, and watchers of both.
struct TwoHands {
  struct Hand {
    RingSource<&ServoChannels::frames> servo;
    RingSource<&ContactChannels::sets> contact;
    ServoFrame frame{};
    ContactSet set{};
  };
  TemporaryRuntimeFolder folder;
  HapticdProcess hapticd{{from_source("configs/two-hands.toml")}, folder.path()};
  Attachments attachments{Watcher::connect("two-hands")};
  std::vector<Hand> hands;

  TwoHands() {
    for (uint32_t hand = 0; hand < 2; ++hand) {
      hands.push_back({attachments.ring<&ServoChannels::frames>(Start::kOldest, hand),
                       attachments.ring<&ContactChannels::sets>(Start::kOldest, hand)});
    }
    attachments.start();
    INFO(hapticd.log());
    for (uint32_t hand = 0; hand < 2; ++hand) REQUIRE(runs(hand));
  }
  /// Both its servo and its contact publish something new.
  bool runs(uint32_t hand) {
    const uint64_t tick = look(hand).frame.tick, set = hands[hand].set.seq;
    return eventually([&] { return look(hand).frame.tick > tick && hands[hand].set.seq != set; });
  }
  Hand& look(uint32_t hand) {
    hands[hand].servo.latest(hands[hand].frame);
    hands[hand].contact.latest(hands[hand].set);
    return hands[hand];
  }
  bool is_closed(uint32_t hand) { return (look(hand).frame.flags & kServoPaused) != 0; }
  pid_t servo(uint32_t hand) { return writer_of(look(hand).servo); }
  pid_t contact(uint32_t hand) { return writer_of(look(hand).contact); }
  Json status() const { return Json::parse(say_to_session("two-hands", "status")); }
  pid_t ready_spare() const {
    const Json spare = status()["spare"];
    return spare["ready"].get<bool>() ? spare["pid"].get<pid_t>() : 0;
  }
};

}  // namespace

TEST_CASE("hands: a command is for all or for one, and the status has both") {
  TwoHands s;
  CHECK(say_to_session("two-hands", "hand left pause") == "ok");
  CHECK(s.is_closed(0));
  CHECK_FALSE(s.is_closed(1));
  CHECK(say_to_session("two-hands", "pause") == "ok");
  CHECK(s.is_closed(1));
  CHECK(say_to_session("two-hands", "hand 1 resume") == "ok");
  CHECK(s.is_closed(0));
  CHECK_FALSE(s.is_closed(1));
  CHECK(say_to_session("two-hands", "hand right set stiffness 500 N/m") == "ok");
  const Json status = s.status();
  REQUIRE(status["hands"].size() == 2);
  CHECK(status["hands"][0]["name"] == "left");
  CHECK(status["hands"][0]["paused"] == true);
  CHECK(status["hands"][0]["stiffness"] == 800);
  CHECK(status["hands"][1]["name"] == "right");
  CHECK(status["hands"][1]["paused"] == false);
  CHECK(status["hands"][1]["stiffness"] == 500);
  const std::string text = say_to_session("two-hands", "status text");
  CHECK(text.find("hand       left\n") != std::string::npos);
  CHECK(text.find("hand       right\n") != std::string::npos);
  CHECK(say_to_session("two-hands", "hand middle pause").find("it has left, right") !=
        std::string::npos);
  CHECK(say_to_session("two-hands", "lead 0 0 0").find("name one hand") != std::string::npos);
  CHECK(say_to_session("two-hands", "hand right lead 0.05 0 0.025") == "ok");
  CHECK(say_to_session("two-hands", "hand right release") == "ok");
}

TEST_CASE("hands: a servo that is killed comes back, and the other hand does not notice") {
  TwoHands s;
  for (uint32_t hand = 0; hand < 2; ++hand) {
    const uint32_t other = 1 - hand;
    const pid_t before = s.servo(hand), untouched = s.servo(other);
    const uint64_t generation = s.hands[other].servo.generation();
    kill(before, SIGKILL);
    INFO(s.hapticd.log());
    CHECK(eventually([&] { return s.servo(hand) != before && s.runs(hand); }));
    CHECK(s.runs(other));
    CHECK(s.servo(other) == untouched);
    CHECK(s.hands[other].servo.generation() == generation);
  }
}

TEST_CASE("hands: one spare takes the place of whichever contact dies") {
  TwoHands s;
  for (const uint32_t hand : {1u, 0u, 1u}) {
    pid_t spare = 0;
    REQUIRE(eventually([&] { return (spare = s.ready_spare()) != 0; }));
    const pid_t before = s.contact(hand), untouched = s.contact(1 - hand);
    kill(before, SIGKILL);
    INFO(s.hapticd.log());
    CHECK(eventually([&] { return s.contact(hand) == spare; }));
    CHECK(s.runs(hand));
    CHECK(s.runs(1 - hand));
    CHECK(s.contact(1 - hand) == untouched);
  }
}

TEST_CASE("hands: a recording has both, and what they push moves one body") {
  TwoHands s;
  const Ran ran = hapt("record -o two.mcap --for 3 --json", s.folder.path());
  INFO(ran.output);
  REQUIRE(ran.code == 0);
  const TraceReader trace(s.folder.path() + "/two.mcap");
  double most[2] = {0, 0};
  for (uint32_t hand = 0; hand < 2; ++hand) {
    CHECK(trace.read(contact_topic(hand)).size() > 1000);
    CHECK(trace.read(control_topic(hand)).size() > 5);
    for (const auto& frame : trace.read(servo_topic(hand))) {
      most[hand] = std::max(most[hand], std::fabs(frame.F_coupling_W.f.x));
    }
  }
  CHECK(most[0] > 0.5);
  CHECK(most[1] > 0.5);
}

}  // namespace haptic
