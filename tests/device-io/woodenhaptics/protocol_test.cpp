// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/woodenhaptics/protocol.h"

#include <catch2/catch.hpp>
#include <random>
#include <string>
#include <vector>

using namespace haptic;

namespace {

/// All answers in a text, pushed byte by byte.
std::vector<EncoderReply> answers_in(std::string_view text, uint64_t* rejected = nullptr) {
  ReplyReader reader;
  std::vector<EncoderReply> out;
  EncoderReply reply;
  for (const char c : text) {
    if (reader.push(c, reply)) out.push_back(reply);
  }
  if (rejected != nullptr) *rejected = reader.rejected();
  return out;
}

const std::string kGood = "[3,1,-22,333,-4,5,-6,0]\n";

bool is_good(const EncoderReply& r) {
  return r.model == 3 && r.counts == std::array<int32_t, 6>{1, -22, 333, -4, 5, -6} && r.error == 0;
}

}  // namespace

TEST_CASE("protocol: a command is three whole numbers in brackets and a line end", "[device-io]") {
  CHECK(encode_currents({0, 0, 0}).view() == kZeroCommand);
  CHECK(encode_currents({3000, -7, 12}).view() == "[3000,-7,12]\n");
  const int32_t least = std::numeric_limits<int32_t>::min();
  CHECK(encode_currents({least, least, least}).view() == "[-2147483648,-2147483648,-2147483648]\n");
}

TEST_CASE("protocol: an answer is read wherever the stream is cut", "[device-io]") {
  ReplyReader reader;
  EncoderReply reply;
  for (size_t cut = 0; cut <= kGood.size(); ++cut) {
    bool found = false;
    for (const char c : kGood.substr(0, cut)) found |= reader.push(c, reply);
    // time passes
    for (const char c : kGood.substr(cut)) found |= reader.push(c, reply);
    CAPTURE(cut);
    REQUIRE(found);
    REQUIRE(is_good(reply));
  }
  CHECK(reader.rejected() == 0);
}

TEST_CASE("protocol: what is no answer is passed over and the next one is read", "[device-io]") {
  const auto [what, text, rejects] = GENERATE(table<std::string, std::string, uint64_t>({
      {"noise without brackets", "hello, 3,1,2]\n\r\n", 0},
      {"zero bytes", std::string("\0\0\0", 3), 0},
      {"torn before its end", "[3,1,-22,3", 1},
      {"torn at its beginning", "2,333,-4,5,-6,0]\n", 0},
      {"too few numbers", "[3,1,2,3,4,5,0]\n", 1},
      {"too many numbers", "[3,1,2,3,4,5,6,0,0]\n", 1},
      {"a word", "[3,nan,2,3,4,5,6,0]\n", 1},
      {"infinity", "[3,inf,2,3,4,5,6,0]\n", 1},
      {"a fraction", "[3,1.5,2,3,4,5,6,0]\n", 1},
      {"an exponent", "[3,1e9,2,3,4,5,6,0]\n", 1},
      {"hexadecimal", "[3,0x10,2,3,4,5,6,0]\n", 1},
      {"a plus sign", "[3,+1,2,3,4,5,6,0]\n", 1},
      {"a blank", "[3, 1,2,3,4,5,6,0]\n", 1},
      {"an empty number", "[3,,2,3,4,5,6,0]\n", 1},
      {"beyond 32 bits", "[3,2147483648,2,3,4,5,6,0]\n", 1},
      {"nothing", "[]\n", 1},
      {"an overlong line", "[" + std::string(5000, '1') + "]\n", 1},
      {"an overlong number", "[3,9,9,9,9,9,9," + std::string(200, '0') + "7]\n", 1},
      {"brackets in brackets", "[[[", 2 + 1},
  }));
  CAPTURE(what);
  uint64_t rejected = 0;
  const auto answers = answers_in(text + kGood, &rejected);
  REQUIRE(answers.size() == 1);
  CHECK(is_good(answers[0]));
  CHECK(rejected == rejects);
}

TEST_CASE("protocol: the largest numbers fit", "[device-io]") {
  std::string text = "[";
  for (int i = 0; i < 8; ++i) text += "-2147483648,";
  text.back() = ']';
  const auto answers = answers_in(text);
  REQUIRE(answers.size() == 1);
  CHECK(answers[0].counts[5] == std::numeric_limits<int32_t>::min());
}

TEST_CASE("protocol: random bytes give no answer out of range of the reader and never stop it",
          "[device-io]") {
  std::mt19937 random(1);
  constexpr std::string_view kLikely = "[],-0123456789\n";
  std::string text;
  for (int i = 0; i < 200'000; ++i) {
    const bool likely = random() % 8 != 0;
    text += likely ? kLikely[random() % kLikely.size()] : static_cast<char>(random());
  }
  answers_in(text);
  // after any input, a line end and a whole line are read
  REQUIRE(answers_in(text + kGood).size() >= 1);
  CHECK(is_good(answers_in(text + kGood).back()));
}
