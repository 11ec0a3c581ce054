// SPDX-License-Identifier: GPL-3.0-or-later
// The line of docs/six-motors.md, and that of three motors, byte by byte: what the emulated board
// says to whatever reaches it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "device-io/emulator/firmware.h"
#include "device-io/hand/impedance.h"
#include "device-io/sixmotors/kinematics.h"
#include "device-io/woodenhaptics/protocol.h"
#include "proto/math/units.h"

using namespace haptic;

namespace {

/// A board at whose handle nothing happens: nobody holds it, and friction keeps it.
EmulatedDevice quiet_board(const Arm& arm = six_motors_arm()) {
  EmulatedDeviceOptions options;
  options.arm = &arm;
  options.hand.inertia = 1e-4;
  put_into_hand(*find_hand("none"), options.hand);
  return EmulatedDevice(options, 0);
}

std::string tell(EmulatedDevice& board, std::string_view text, int64_t t_ns) {
  board.receive({text.data(), text.size()});
  std::string said;
  for (int i = 0; i < 20; ++i) {
    board.turn(t_ns);
    said += board.answer();
  }
  return said;
}

/// With the numbers of so many motors for each #; without the first of them for ~, with a letter
/// for the last for $, without the second for %; all but the last for &; as many as the other
/// board has for *; large ones for ^.
std::string filled(const std::string& text, size_t motors) {
  const std::string all = "10,20,30,40,50,60", numbers = all.substr(0, 3 * motors - 1);
  std::string out;
  for (const char c : text) {
    if (c == '#') out += numbers;
    if (c == '~') out += numbers.substr(2);
    if (c == '$') out += numbers.substr(0, 3 * motors - 3) + "x";
    if (c == '%') out += numbers.substr(0, 3) + numbers.substr(5);
    if (c == '&') out += numbers.substr(0, 3 * motors - 4);
    if (c == '*') out += motors == 3 ? all : all.substr(0, 8);
    if (c == '^') out += motors == 3 ? "6000,6001,-6000" : "6000,6001,-6000,-6001,6000,9999";
    if (std::string_view("#~$%&*^").find(c) == std::string_view::npos) out += c;
  }
  return out;
}

}  // namespace

TEST_CASE("six motors line: a command is six whole numbers in brackets and a line end",
          "[device-io]") {
  CHECK(encode_currents({}, Challenge::kNone, 6).view() == "[0,0,0,0,0,0]\n");
  CHECK(encode_currents({1, -2, 3, -4, 5, -6}, Challenge::kNone, 6).view() == "[1,-2,3,-4,5,-6]\n");
  CHECK(encode_currents({1, 2, 3, 4, 5, 6}, Challenge::kNoBegin, 6).view() == "]\n[1,2,3,4,5,6]\n");
  CHECK(encode_currents({1, 2, 3, 4, 5, 6}, Challenge::kNotAsMany, 6).view() ==
        "[]\n[1,2,3,4,5,6]\n");
  // the longest line of all
  const int32_t least = std::numeric_limits<int32_t>::min();
  const CommandText longest =
      encode_currents({least, least, least, least, least, least}, Challenge::kNotAsMany, 6);
  std::string expected = "[]\n[";
  for (int i = 0; i < 6; ++i) expected += "-2147483648,";
  expected.back() = ']';
  CHECK(longest.view() == expected + "\n");
}

TEST_CASE("six motors line: each line has the answer that the table says", "[device-io]") {
  const Arm& arm = GENERATE(false, true) ? six_motors_arm() : woodenhaptics_arm();
  constexpr Milliamperes kBefore{7, 7, 7, 7, 7, 7}, kNumbers{10, 20, 30, 40, 50, 60};
  auto [text, errors, obeyed] = GENERATE_COPY(table<std::string, std::vector<int>, Milliamperes>({
      {"[#]\n", {0}, kNumbers},
      {"[#]\r\n", {0}, kNumbers},
      {"noise[#]\n", {0}, kNumbers},
      {"[1,[#]\n", {512}, kBefore},  // commas count from the line's begin
      {"[^]\n", {0}, {6000, 0, -6000, 0, 6000, 0}},
      {"[1,2]\n", {512}, kBefore},
      {"[&]\n", {512}, kBefore},
      {"[*]\n", {512}, kBefore},
      {"[#,7]\n", {512}, kBefore},
      {"[]\n", {512}, kBefore},
      {"]\n", {256}, kBefore},
      {"#]\n", {256}, kBefore},
      {"[a#]\n", {1024}, kBefore},
      {"[$]\n", {1024}, kBefore},
      {"[~]\n", {1024}, kBefore},
      {"[%]\n", {1024}, kBefore},
      {"[#] \n", {8}, kBefore},
      {std::string(127, '7'), {128}, kBefore},
      // both of two lines at once are lost
      {"[#]\n[#]\n", {8, 256}, kBefore},
  }));
  CAPTURE(arm.name, text);
  EmulatedDevice board = quiet_board(arm);
  Milliamperes before = kBefore;
  std::fill(before.begin() + static_cast<ptrdiff_t>(arm.motors), before.end(), 0);
  std::fill(obeyed.begin() + static_cast<ptrdiff_t>(arm.motors), obeyed.end(), 0);
  // the counts of the middle of the workspace, after a valid line at the same place
  const CommandText first = encode_currents(before, Challenge::kNone, arm.motors);
  const std::string said = tell(board, first.view(), kMs);
  const std::string counts = said.substr(0, said.rfind(',') + 1);  // "[6,e0,…,e5,"
  REQUIRE(counts.rfind("[" + std::to_string(arm.model) + ",", 0) == 0);
  std::string expected;
  for (const int error : errors) expected += counts + std::to_string(error) + "]\n";
  CHECK(tell(board, filled(text, arm.motors), kMs) == expected);
  CHECK(board.record().currents == obeyed);
  const size_t rejected = errors == std::vector{0} ? 0 : errors.size();
  CHECK(board.record().rejected == rejected);
  CHECK(board.record().commands == (rejected == 0 ? 2 : 1));
}

TEST_CASE("six motors line: a line cut in two is one line", "[device-io]") {
  EmulatedDevice board = quiet_board();
  const std::string line = "[11,-12,13,-14,15,-16]\n";
  for (size_t cut = 1; cut < line.size() - 1; ++cut) {
    const int64_t t_ns = static_cast<int64_t>(cut) * kMs;
    const std::string first = tell(board, line.substr(0, cut), t_ns);
    const std::string said = first + tell(board, line.substr(cut), t_ns);
    CAPTURE(cut, said);
    REQUIRE(said.substr(said.rfind(',')) == ",0]\n");
    REQUIRE(board.record().currents == Milliamperes{11, -12, 13, -14, 15, -16});
    tell(board, "[0,0,0,0,0,0]\n", t_ns);
  }
}

TEST_CASE("six motors line: a board with three motors is refused by its count alone",
          "[device-io]") {
  EmulatedDeviceOptions options;  // a WoodenHaptics
  EmulatedDevice board(options, 0);
  const std::string said = tell(board, "[1,2,3,4,5,6]\n", kMs);
  CHECK(said.substr(said.rfind(',')) == ",512]\n");
  CHECK(board.record().currents == Milliamperes{});
}
