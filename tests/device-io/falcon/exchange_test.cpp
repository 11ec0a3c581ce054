// SPDX-License-Identifier: GPL-3.0-or-later
// The Falcon's exchange and driver against packets of the chip that are right, damaged, cut,
// doubled or old.
#include "device-io/falcon/exchange.h"

#include <catch2/catch.hpp>
#include <random>
#include <string_view>
#include <vector>

#include "device-io/falcon/falcon.h"
#include "tests/support/driver/spoiled.h"
#include "tests/support/torture_scale.h"

using namespace haptic;

namespace {

using Bytes = std::vector<uint8_t>;

/// An honest answer with these counts, after the chip's two bytes.
Bytes answer_of(const FalconBytes& question, const std::array<int16_t, 3>& counts) {
  const bool homing = ((question[13] - 'A') & kFalconHoming) != 0;
  FalconBytes packet = encode_falcon({counts, 0});
  packet[13] = static_cast<uint8_t>('A' + (homing ? kFalconLegs : 0));
  Bytes out{0x01, 0x60};
  out.insert(out.end(), packet.begin(), packet.end());
  return out;
}

}  // namespace

TEST_CASE("falcon exchange: whose turn it is follows from questions and answers", "[device-io]") {
  using State = FalconTurn::State;
  // q a question, a an answer, x a distrust, 0 brought up anew
  const auto after = [](std::string_view events) {
    FalconTurn turn;
    for (const char event : events) {
      turn = turn.after(event == 'q'   ? FalconTurn::Event::kAsk
                        : event == 'a' ? FalconTurn::Event::kAnswer
                        : event == 'x' ? FalconTurn::Event::kDistrust
                                       : FalconTurn::Event::kBroughtUp);
    }
    return turn;
  };
  CHECK(after("").state == State::kFree);
  CHECK(after("q").state == State::kAsked);
  CHECK(after("qa").state == State::kFree);
  CHECK(after("qq").state == State::kAskedAgain);
  CHECK(after("qqqa").state == State::kDraining);
  CHECK(after("qqqaaa").state == State::kFree);
  CHECK(after("qqaq").owed == 1);
  CHECK(after("qaa").state == State::kHushed);
  CHECK(after("qqx").owed == 0);
  CHECK(after("qxq").state == State::kAsked);
  CHECK(after("qqx0").state == State::kFree);
}

TEST_CASE("falcon exchange: fuzz: packets that are right, damaged, cut, doubled or old",
          "[device-io][fuzz]") {
  // 10⁷: HAPTIC_TORTURE_SCALE=500, with a sanitizer 10000
  const size_t n = test::sweep(20'000);
  const size_t fresh = test::fuzz_exchange<FalconExchange>(
      falcon_arm({}), falcon_flags(), n, 2, kMostFalconWord, {0, 0, 1},
      [](const FalconBytes& question, std::mt19937& random) {
        const auto count = [&] {
          return static_cast<int16_t>(static_cast<int>(random() % 800) - 600);
        };
        return answer_of(question, {count(), count(), count()});
      });
  CHECK(fresh > n / 4);
}
