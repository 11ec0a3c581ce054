// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/haply/packet.h"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/support/torture_scale.h"

using namespace haptic;

namespace {

using Bytes = std::vector<uint8_t>;

template <size_t N>
Bytes bytes_of(const std::array<uint8_t, N>& bytes) {
  return {bytes.begin(), bytes.end()};
}

std::vector<HaplyAnswer> read_all(HaplyReader& reader, const Bytes& stream) {
  std::vector<HaplyAnswer> all;
  HaplyAnswer answer;
  for (const uint8_t byte : stream) {
    if (reader.push(byte, answer)) all.push_back(answer);
  }
  return all;
}

/// The bytes as a board sends them: by the memory of this machine, which is little-endian as the
/// board's.
Bytes answer_of(uint8_t number, float first, float second) {
  Bytes bytes{number, kHaplyDevice};
  for (const float value : {first, second}) {
    const auto raw = std::bit_cast<std::array<uint8_t, 4>>(value);
    bytes.insert(bytes.end(), raw.begin(), raw.end());
  }
  return bytes;
}

}  // namespace

// Vectors of Haply-API-cpp (c336a06), example/main.cpp: device 5, motors and encoders on ports 1
// and 2, all clockwise, 13,824 counts of a turn, links at 180° and 0° where it is set up. Its
// Device.cpp shifts the mask of ports in from bit 3, and Board.cpp sends floats low byte first; a
// reset is a type and a device, both 0.
TEST_CASE("haply packets: as hAPI has them", "[device-io]") {
  CHECK(bytes_of(encode_haply_setup(5, {{{180, 13824}, {0, 13824}}})) ==
        Bytes{1,    5, 3, 0,    0,    3, 0, 0, 0, 0, 0, 0,    0x34,
              0x43, 0, 0, 0x58, 0x46, 0, 0, 0, 0, 0, 0, 0x58, 0x46});
  CHECK(bytes_of(encode_haply_torques(5, {0, 0})) == Bytes{2, 5, 0, 0, 0, 0, 0, 0, 0, 0});
  CHECK(bytes_of(encode_haply_torques(5, {0.123f, -0.05f})) ==
        Bytes{2, 5, 0x6d, 0xe7, 0xfb, 0x3d, 0xcd, 0xcc, 0x4c, 0xbd});
  CHECK(bytes_of(kHaplyReset) == Bytes{0, 0});
}

TEST_CASE("haply packets: a question is a number, then torques in 10 uN m", "[device-io]") {
  CHECK(bytes_of(encode_haply(0x20, 12'300, -5'000)) ==
        Bytes{2, 0x20, 2, 0x11, 0x6d, 0xe7, 0xfb, 0x3d, 0xcd, 0xcc, 0x4c, 0xbd});
}

TEST_CASE("haply packets: an answer behind its number", "[device-io]") {
  HaplyReader reader;
  // −1447 and 6912 as floats
  const auto answers =
      read_all(reader, {0x20, 0x11, 0x00, 0xe0, 0xb4, 0xc4, 0x00, 0x00, 0xd8, 0x45});
  REQUIRE(answers.size() == 1);
  CHECK(answers[0].number == 0x20);
  CHECK(answers[0].counts == std::array<int16_t, 2>{-1447, 6912});
  CHECK(reader.passed_over() == 0);
}

TEST_CASE("haply packets: halves, noise, and answers without a number", "[device-io]") {
  HaplyReader reader;
  const Bytes whole = answer_of(0x30, 12, -7);
  const Bytes half(whole.begin(), whole.begin() + 5);
  CHECK(read_all(reader, half).empty());
  CHECK(read_all(reader, Bytes(whole.begin() + 5, whole.end())).size() == 1);
  // cut off by the next one
  Bytes stream = half;
  stream.insert(stream.end(), whole.begin(), whole.end());
  CHECK(read_all(reader, stream).size() == 1);
  // to the zero of hapticd: the device's number and two angles
  stream = Bytes(whole.begin() + 1, whole.end());
  CHECK(read_all(reader, stream).empty());
  CHECK(read_all(reader, whole).size() == 1);
}

TEST_CASE("haply packets: what is no count is no answer", "[device-io]") {
  HaplyReader reader;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  for (const float value : {nan, infinite, -infinite, 0.5f, 40'000.f, -1e30f, 1e-30f}) {
    CHECK(read_all(reader, answer_of(0x30, value, 0)).empty());
    CHECK(read_all(reader, answer_of(0x30, 0, value)).empty());
  }
  CHECK(read_all(reader, answer_of(0x30, 32'767, -32'767)).size() == 1);
  CHECK(read_all(reader, answer_of(0x11, 0, 0)).empty());
  CHECK(read_all(reader, answer_of(0x39, 0, 0)).empty());
}

TEST_CASE("haply packets: a packet that is cut off makes no torque of note", "[device-io]") {
  // the board takes the first bytes of the next question for the end of a float
  for (int number = kFirstNumber; number <= kLastNumber; ++number) {
    for (const uint8_t end : {static_cast<uint8_t>(number), kHaplyDevice, uint8_t{2}}) {
      const std::array<uint8_t, 4> bytes{0xff, 0xff, 0xff, end};
      CHECK(std::fabs(std::bit_cast<float>(bytes)) < 2e-4f);
    }
  }
}

TEST_CASE("haply packets: what was sent is received, among lost and spoiled bytes", "[device-io]") {
  // 10⁷ packets: HAPTIC_TORTURE_SCALE=500, with a sanitizer 10000
  std::mt19937 random(20);
  HaplyReader reader;
  size_t heard = 0, wrong = 0;
  const size_t n = test::sweep(20'000);
  for (size_t k = 0; k < n; ++k) {
    const std::array<int16_t, 2> sent{static_cast<int16_t>(random() % 65'535 - 32'767),
                                      static_cast<int16_t>(random() % 65'535 - 32'767)};
    const auto number = static_cast<uint8_t>(kFirstNumber + random() % 39);
    Bytes bytes = answer_of(number, sent[0], sent[1]);
    const auto fate = random() % 8;
    const auto at = random() % bytes.size();
    if (fate == 0) bytes[at] = static_cast<uint8_t>(random());
    HaplyAnswer answer;
    for (size_t i = 0; i < bytes.size(); ++i) {
      if (fate == 1 && i == at) continue;
      if (!reader.push(bytes[i], answer)) continue;
      ++heard;
      const bool same = answer.counts == sent && answer.number == number;
      wrong += same ? 0 : 1;
      if (fate > 1) CHECK(same);
    }
  }
  // a spoiled byte may leave another whole number: nothing in the packet would say so
  CHECK(wrong < n / 8);
  CHECK(heard > n * 6 / 8);
}

TEST_CASE("haply packets: random bytes do no harm", "[device-io]") {
  std::mt19937 random(21);
  HaplyReader reader;
  HaplyAnswer answer;
  const Bytes likely{0x11, 0x20, 0, 0, 0, 0, 0, 0, 0x80, 0x3f};
  size_t heard = 0;
  for (size_t k = 0; k < test::sweep(300'000); ++k) {
    const auto r = random();
    const uint8_t byte =
        (r & 0xf00u) == 0 ? static_cast<uint8_t>(r) : likely[(r >> 12) % likely.size()];
    if (!reader.push(byte, answer)) continue;
    ++heard;
    CHECK(answer.number >= kFirstNumber);
    CHECK(answer.number <= kLastNumber);
  }
  CHECK(heard > 0);
}
