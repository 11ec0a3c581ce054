// SPDX-License-Identifier: GPL-3.0-or-later
// The line of docs/six-motors.md byte by byte: what the emulated board says to whatever reaches it.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "device-io/emulator/firmware.h"
#include "device-io/hand/impedance.h"
#include "device-io/sixmotors/kinematics.h"
#include "device-io/woodenhaptics/protocol.h"

using namespace haptic;

namespace {

constexpr int64_t kMs = 1'000'000;

/// A board at whose handle nothing happens: nobody holds it, and friction keeps it.
EmulatedDevice quiet_board() {
  EmulatedDeviceOptions options;
  options.arm = &six_motors_arm();
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
  // the counts of the middle of the workspace, after a valid line at the same place
  const auto [text, errors, obeyed] = GENERATE(table<std::string, std::vector<int>, Milliamperes>({
      {"[10,20,30,40,50,60]\n", {0}, {10, 20, 30, 40, 50, 60}},
      {"[-1,-2,-3,-4,-5,-6]\r\n", {0}, {-1, -2, -3, -4, -5, -6}},
      {"noise[1,2,3,4,5,6]\n", {0}, {1, 2, 3, 4, 5, 6}},
      {"[1,[1,2,3,4,5,6]\n", {512}, {7, 7, 7, 7, 7, 7}},  // commas count from the line's begin
      {"[6000,6001,-6000,-6001,6000,9999]\n", {0}, {6000, 0, -6000, 0, 6000, 0}},
      {"[1,2,3]\n", {512}, {7, 7, 7, 7, 7, 7}},
      {"[1,2,3,4,5]\n", {512}, {7, 7, 7, 7, 7, 7}},
      {"[1,2,3,4,5,6,7]\n", {512}, {7, 7, 7, 7, 7, 7}},
      {"[]\n", {512}, {7, 7, 7, 7, 7, 7}},
      {"]\n", {256}, {7, 7, 7, 7, 7, 7}},
      {"1,2,3,4,5,6]\n", {256}, {7, 7, 7, 7, 7, 7}},
      {"[a,b,c,d,e,f]\n", {1024}, {7, 7, 7, 7, 7, 7}},
      {"[1,2,3,4,5,x]\n", {1024}, {7, 7, 7, 7, 7, 7}},
      {"[1,2,,4,5,6]\n", {1024}, {7, 7, 7, 7, 7, 7}},
      {"[1,2,3,4,5,6] \n", {8}, {7, 7, 7, 7, 7, 7}},
      {std::string(127, '7'), {128}, {7, 7, 7, 7, 7, 7}},
      // both of two lines at once are lost
      {"[1,1,1,1,1,1]\n[2,2,2,2,2,2]\n", {8, 256}, {7, 7, 7, 7, 7, 7}},
  }));
  CAPTURE(text);
  EmulatedDevice board = quiet_board();
  const std::string before = tell(board, "[7,7,7,7,7,7]\n", kMs);
  REQUIRE(before.size() > 5);
  const std::string counts = before.substr(0, before.rfind(',') + 1);  // "[6,e0,…,e5,"
  CHECK(counts.rfind("[6,", 0) == 0);
  std::string expected;
  for (const int error : errors) expected += counts + std::to_string(error) + "]\n";
  CHECK(tell(board, text, kMs) == expected);
  CHECK(board.record().currents == obeyed);
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
