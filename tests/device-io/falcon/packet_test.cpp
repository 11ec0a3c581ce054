// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/packet.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "tests/support/torture_scale.h"

using namespace haptic;

namespace {

std::string text_of(const FalconBytes& bytes) {
  return {bytes.begin(), bytes.end()};
}

/// Answers found in a stream.
std::vector<MotorSample> read_all(FalconReader& reader, const std::string& stream) {
  std::vector<MotorSample> all;
  MotorSample answer;
  for (const char c : stream) {
    if (reader.push(static_cast<uint8_t>(c), answer)) all.push_back(answer);
  }
  return all;
}

}  // namespace

// Vectors of libnifalcon (f7c727a): findfalcons.c sends the neutral packet; the description of the
// firmware gives "JFKP" as its example of a number, which its code reads as −1447; nibbles go from
// the least significant up, each plus 0x41.
TEST_CASE("falcon packets: as libnifalcon has them", "[device-io]") {
  CHECK(text_of(encode_falcon({})) == "<AAAAAAAAAAAAAA>");
  FalconReader reader;
  const auto answers = read_all(reader, "<JFKPAAAABAAAAA>");
  REQUIRE(answers.size() == 1);
  CHECK(answers[0].counts == std::array<int16_t, 3>{-1447, 0, 1});
  // −1447 is 0xFA59
  CHECK(text_of(encode_falcon({{-1447, 0x0123, 0}, 0})) == "<JFKPDCBAAAAAAA>");
  // NOVINT_TEST_FW_HOMING_MODE is 1, the lights are bits 1 to 3
  CHECK(text_of(encode_falcon({.motors = {}, .flags = 0x03})) == "<AAAAAAAAAAAADA>");
}

TEST_CASE("falcon packets: buttons and homed legs", "[device-io]") {
  FalconReader reader;
  const std::string all{"<AAAAAAAAAAAA", 13};
  const auto with = [&](int flags) { return all + static_cast<char>(0x41 + flags) + "A>"; };
  auto answers = read_all(reader, with(0x4 | 0x50));
  REQUIRE(answers.size() == 1);
  CHECK((answers[0].flags & kFalconButtons) == 4);
  CHECK((answers[0].flags & kFalconLegs) >> kFalconLegsAt == 5);
  // all legs and all buttons: a byte beyond the printable ones
  answers = read_all(reader, with(0x7f));
  REQUIRE(answers.size() == 1);
  CHECK(answers[0].flags == (kFalconButtons | kFalconLegs));
}

TEST_CASE("falcon packets: half packets, and noise before a packet", "[device-io]") {
  FalconReader reader;
  CHECK(read_all(reader, "<BAAAAAA").empty());
  CHECK(read_all(reader, "ACAAAAA>").size() == 1);
  // an end without a beginning; a beginning that is cut off by the next one
  CHECK(read_all(reader, "AAAA>\r\n").empty());
  const auto answers = read_all(reader, "<AAAA<CAAAAAAAAAAAAA><DAAAAAAAAAAAAA>");
  REQUIRE(answers.size() == 2);
  CHECK(answers[0].counts[0] == 2);
  CHECK(answers[1].counts[0] == 3);
  CHECK(reader.rejected() == 1);
}

TEST_CASE("falcon packets: what was sent is received, among lost and spoiled bytes",
          "[device-io]") {
  // 10⁷ packets: HAPTIC_TORTURE_SCALE=500, with a sanitizer 10000
  std::mt19937 random(20);
  FalconReader reader;
  size_t heard = 0, wrong = 0;
  const size_t n = test::sweep(20'000);
  for (size_t k = 0; k < n; ++k) {
    MotorCommand sent;
    for (int16_t& motor : sent.motors) motor = static_cast<int16_t>(random());
    FalconBytes bytes = encode_falcon(sent);
    const auto fate = random() % 8;
    const auto at = random() % bytes.size();
    if (fate == 0) bytes[at] = static_cast<uint8_t>(random());
    MotorSample answer;
    for (size_t i = 0; i < bytes.size(); ++i) {
      if (fate == 1 && i == at) continue;
      if (!reader.push(bytes[i], answer)) continue;
      ++heard;
      wrong += answer.counts != sent.motors ? 1 : 0;
      if (fate > 1) CHECK(answer.counts == sent.motors);
    }
  }
  // a spoiled letter may be another letter: nothing in the packet would say so
  CHECK(wrong < n / 8);
  CHECK(heard > n * 5 / 8);
}

TEST_CASE("falcon packets: random bytes do no harm", "[device-io]") {
  std::mt19937 random(21);
  FalconReader reader;
  MotorSample answer;
  const std::string likely = "<>ABCDEFGHIJKLMNOP";
  for (size_t k = 0; k < test::sweep(300'000); ++k) {
    const auto r = random();
    const uint8_t byte = (r & 256u) != 0 ? static_cast<uint8_t>(r)
                                         : static_cast<uint8_t>(likely[(r >> 9) % likely.size()]);
    if (!reader.push(byte, answer)) continue;
    CHECK(answer.flags <= 0x7f);
  }
}
