// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/haply/exchange.h"

#include <bit>
#include <catch2/catch.hpp>
#include <random>
#include <set>
#include <vector>

#include "device-io/haply/haply.h"
#include "proto/math/units.h"
#include "tests/support/driver/spoiled.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

using AnswerBytes = std::array<uint8_t, 10>;

AnswerBytes answer_bytes(uint8_t number, float first, float second) {
  AnswerBytes bytes{number, kHaplyDevice};
  const auto a = std::bit_cast<std::array<uint8_t, 4>>(first);
  const auto b = std::bit_cast<std::array<uint8_t, 4>>(second);
  std::copy(a.begin(), a.end(), bytes.begin() + 2);
  std::copy(b.begin(), b.end(), bytes.begin() + 6);
  return bytes;
}

}  // namespace

TEST_CASE("haply exchange: each question has another number than the last", "[device-io]") {
  MotorMailbox mailbox;
  HaplyExchange exchange(mailbox);
  std::set<uint8_t> numbers;
  uint8_t before = 0;
  for (int i = 1; i <= 2000; ++i) {
    REQUIRE(exchange.may_ask(i * kMs));
    const HaplyQuestion question = exchange.ask(i * kMs);
    CHECK(question[1] != before);
    CHECK(question[1] >= kFirstNumber);
    CHECK(question[1] <= kLastNumber);
    before = question[1];
    numbers.insert(before);
    CHECK_FALSE(exchange.may_ask(i * kMs + 1));
    exchange.hear(answer_bytes(before, 1, 2), i * kMs + 500'000);
  }
  CHECK(numbers.size() == 39);
  CHECK(exchange.answered() == 2000);
}

TEST_CASE("haply exchange: a question is repeated with its number, and all its answers may come",
          "[device-io]") {
  MotorMailbox mailbox;
  HaplyExchange exchange(mailbox);
  const uint8_t number = exchange.ask(kMs)[1];
  CHECK_FALSE(exchange.may_ask(5 * kMs));
  CHECK(exchange.ask(6 * kMs)[1] == number);
  CHECK_FALSE(exchange.may_ask(15 * kMs));
  CHECK(exchange.ask(16 * kMs)[1] == number);
  exchange.hear(answer_bytes(number, 3, 4), 17 * kMs);
  const auto sample = mailbox.newest();
  REQUIRE(sample);
  CHECK(sample->asked_ns == kMs);
  CHECK(sample->heard_ns == 17 * kMs);
  CHECK(sample->counts == std::array<int16_t, 3>{3, 4, 0});
  exchange.ask(18 * kMs);
  exchange.hear(answer_bytes(number, 30, 40), 19 * kMs);
  exchange.hear(answer_bytes(number, 30, 40), 19 * kMs);
  CHECK(exchange.old() == 0);
  exchange.hear(answer_bytes(number, 30, 40), 19 * kMs);
  CHECK(exchange.old() == 1);
  CHECK(mailbox.newest()->counts[0] == 3);
}

TEST_CASE("haply exchange: a torque that the servo has not renewed is zero", "[device-io]") {
  MotorMailbox mailbox;
  HaplyExchange exchange(mailbox);
  mailbox.post({{1000, -1000, 0}, 0}, kMs);
  const HaplyQuestion first = exchange.ask(2 * kMs);
  CHECK(first[11] != 0);
  exchange.hear(answer_bytes(first[1], 0, 0), 3 * kMs);
  const HaplyQuestion late = exchange.ask(12 * kMs);
  CHECK(std::all_of(late.begin() + 4, late.end(), [](uint8_t byte) { return byte == 0; }));
}

TEST_CASE("haply exchange: fuzz: answers that are right, damaged, cut, doubled or old",
          "[device-io]") {
  // 10⁷: HAPTIC_TORTURE_SCALE=250, with a sanitizer 5000
  const size_t n = sweep(40'000);
  const size_t fresh = fuzz_exchange<HaplyExchange>(
      haply_arm({}), {}, n, 0, 12'300, {0, 1, 0},
      [](const HaplyQuestion& question, std::mt19937& random) {
        const auto count = [&] {
          return static_cast<float>(static_cast<int>(random() % 4000) - 2000);
        };
        const AnswerBytes bytes = answer_bytes(question[1], count(), count());
        return std::vector<uint8_t>(bytes.begin(), bytes.end());
      });
  CHECK(fresh > n / 2);
}
