// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/command.cpp.
#include "servo/command.h"

#include <catch2/catch.hpp>
#include <cstring>

using haptic::apply_command;
using haptic::Command;
using haptic::CommandKind;
using haptic::ControlFrame;

TEST_CASE("command: each word changes what it says, and the revision", "[servo]") {
  ControlFrame wanted{};
  wanted.revision = 7;
  CHECK(apply_command("arm", wanted).kind == CommandKind::kChange);
  CHECK(wanted.armed == 1);
  CHECK(wanted.revision == 8);
  apply_command("pause", wanted);
  CHECK(wanted.paused == 1);
  apply_command("resume", wanted);
  CHECK(wanted.paused == 0);
  apply_command("disarm", wanted);
  CHECK(wanted.armed == 0);
  CHECK(apply_command("clear-fault", wanted).clears_fault);
  CHECK(wanted.fault_clears == 1);
  apply_command("set stiffness 500 N/m", wanted);
  CHECK(wanted.translational_stiffness == 500);
  apply_command("set damping 2 N·s/m", wanted);
  CHECK(wanted.translational_damping == 2);
  apply_command("set time-scale 0.5", wanted);
  CHECK(wanted.scene_time_scale == 0.5);
  apply_command("set renderer virtual-proxy3", wanted);
  CHECK(wanted.renderer == static_cast<uint32_t>(haptic::Renderer::kVirtualProxy3));
  CHECK(wanted.revision == 16);
}

TEST_CASE("command: asking and stopping change nothing", "[servo]") {
  ControlFrame wanted{};
  CHECK(apply_command("status", wanted).kind == CommandKind::kStatus);
  CHECK(apply_command(" stop ", wanted).kind == CommandKind::kStop);
  CHECK(wanted.revision == 0);
}

TEST_CASE("command: what is refused says why and changes nothing", "[servo]") {
  const std::string line = GENERATE(
      as<std::string>(), "", "bogus", "arm now", "set", "set stiffness", "set stiffness 500",
      "set stiffness 500 N", "set stiffness -1 N/m", "set stiffness 1e9 N/m",
      "set stiffness nan N/m", "set colour red", "set renderer", "set renderer penalty4",
      "set time-scale fast", "set time-scale -1", "set time-scale 1e400");
  ControlFrame wanted{}, before{};
  const Command command = apply_command(line, wanted);
  CAPTURE(line, command.problem);
  CHECK(command.kind == CommandKind::kRefused);
  CHECK_FALSE(command.problem.empty());
  CHECK(command.problem.find('\n') == std::string::npos);
  // wire structs have no padding: NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
  CHECK(std::memcmp(&wanted, &before, sizeof wanted) == 0);
}
