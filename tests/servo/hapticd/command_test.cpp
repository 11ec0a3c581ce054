// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/hapticd/command.cpp.
#include "servo/hapticd/command.h"
#include "proto/config/devices.h"
#include "proto/ipc/control.h"
#include "proto/wire/renderer.h"

#include <catch2/catch.hpp>
#include <cstring>

using haptic::apply_command;
using haptic::CommandKind;
using haptic::ControlCommand;
using haptic::ControlFrame;

namespace {

/// With a point as the tool.
const haptic::SessionConfig kSession{};

}  // namespace

TEST_CASE("command: each word changes what it says, and the revision", "[servo]") {
  ControlFrame wanted{};
  wanted.revision = 7;
  CHECK(apply_command("arm", kSession, wanted).kind == CommandKind::kChange);
  CHECK(wanted.armed == 1);
  CHECK(wanted.revision == 8);
  apply_command("pause", kSession, wanted);
  CHECK(wanted.paused == 1);
  apply_command("resume", kSession, wanted);
  CHECK(wanted.paused == 0);
  apply_command("disarm", kSession, wanted);
  CHECK(wanted.armed == 0);
  CHECK(apply_command("clear-fault", kSession, wanted).clears_fault);
  CHECK(wanted.fault_clears == 1);
  apply_command("set stiffness 500 N/m", kSession, wanted);
  CHECK(wanted.translational_stiffness == 500);
  apply_command("set damping 0.2 N·s/m", kSession, wanted);
  CHECK(wanted.translational_damping == 0.2);
  apply_command("set rotational-stiffness 2 N·m/rad", kSession, wanted);
  CHECK(wanted.rotational_stiffness == 2);
  apply_command("set rotational-damping 0.001 N·m·s/rad", kSession, wanted);
  CHECK(wanted.rotational_damping == 1e-3);
  apply_command("set time-scale 0.5", kSession, wanted);
  CHECK(wanted.scene_time_scale == 0.5);
  apply_command("set renderer virtual-proxy3", kSession, wanted);
  CHECK(wanted.renderer == static_cast<uint32_t>(haptic::Renderer::kVirtualProxy3));
  CHECK(wanted.revision == 18);
}

TEST_CASE("command: what the device cannot hold is warned of, and far more only by force",
          "[servo]") {
  // 1 kHz, s = 2 and φ = 0.5 give the handle the scene's stiffness; b = 0.5 N·s/m holds 1000 N/m
  haptic::SessionConfig config;
  config.device.hand.damping = 0.5;
  config.map.motion_scale = 2;
  config.map.force_scale = 0.5;
  ControlFrame wanted = haptic::initial_control(config);
  CHECK(apply_command("set stiffness 990 N/m", config, wanted).warning.empty());
  const ControlCommand warned = apply_command("set stiffness 1500 N/m", config, wanted);
  CHECK(warned.kind == CommandKind::kChange);
  CHECK(warned.warning.find("= 1000 N/m") != std::string::npos);
  CHECK(apply_command("set time-scale 0.5", config, wanted).warning.empty());
  const ControlCommand refused = apply_command("set stiffness 2001 N/m", config, wanted);
  CHECK(refused.kind == CommandKind::kRefused);
  CHECK(refused.problem.find("= 1000 N/m") != std::string::npos);
  CHECK(refused.problem.find("--force") != std::string::npos);
  CHECK(wanted.translational_stiffness == 1500);
  CHECK(apply_command("set stiffness 2001 N/m --force", config, wanted).kind ==
        CommandKind::kChange);
  CHECK(wanted.translational_stiffness == 2001);
  // it stays, and more of it is asked for anew
  CHECK(apply_command("pause", config, wanted).kind == CommandKind::kChange);
  CHECK(apply_command("set time-scale 1", config, wanted).kind == CommandKind::kChange);
  CHECK(apply_command("set stiffness 2002 N/m", config, wanted).kind == CommandKind::kRefused);
  // less of it is taken, and another axis is judged by itself
  CHECK(apply_command("set stiffness 3000 N/m --force", config, wanted).kind ==
        CommandKind::kChange);
  CHECK(apply_command("set stiffness 2500 N/m", config, wanted).kind == CommandKind::kChange);
  haptic::SessionConfig turning = config;
  turning.device.max_torque = 1;
  turning.device.hand.inertia = 1e-4;
  turning.device.hand.rotational_damping = 1e-3;
  CHECK(apply_command("set rotational-stiffness 9 N·m/rad", turning, wanted).kind ==
        CommandKind::kRefused);
  // a handle that cannot turn feels none of it
  turning.device.hand.inertia = 0;
  CHECK(apply_command("set rotational-stiffness 9 N·m/rad", turning, wanted).kind ==
        CommandKind::kChange);
  // its damping is taken from what the device has: 2 · 0.1 · 1000 / s = 200 N/m
  apply_command("set stiffness 450 N/m", config, wanted);
  CHECK(apply_command("set damping 0.4 N·s/m", config, wanted).kind == CommandKind::kRefused);
  CHECK(apply_command("set damping 0.3 N·s/m", config, wanted).kind == CommandKind::kChange);
  // twice the rate holds twice as much
  config.servo_rate = 2000;
  CHECK(apply_command("set damping 0.4 N·s/m", config, wanted).kind == CommandKind::kChange);
}

TEST_CASE("command: asking and stopping change nothing", "[servo]") {
  ControlFrame wanted{};
  CHECK(apply_command("status", kSession, wanted).kind == CommandKind::kQuestion);
  CHECK(apply_command("status  text", kSession, wanted).kind == CommandKind::kQuestion);
  const ControlCommand config = apply_command("config", kSession, wanted);
  CHECK(config.answer({}, "# a file") == "# a file");
  CHECK(apply_command(" stop ", kSession, wanted).kind == CommandKind::kStop);
  CHECK(wanted.revision == 0);
}

TEST_CASE("command: what is refused says why and changes nothing", "[servo]") {
  const std::string line = GENERATE(
      as<std::string>(), "", "bogus", "arm now", "set", "set stiffness", "set stiffness 500",
      "set stiffness 500 N", "set stiffness -1 N/m", "set stiffness 1e9 N/m",
      "set stiffness nan N/m", "set colour red", "set renderer", "set renderer penalty4",
      "set renderer direct6", "set renderer voxel", "set rotational-stiffness 5 N/m",
      "set time-scale fast", "set time-scale -1", "set time-scale 1e400", "set solver",
      "set solver quick", "set solver direct", "lead", "lead 0 0", "lead 0 0 nan", "lead 0 0 inf",
      "lead 0 0 1e9", "lead 0 0 0 1", "lead 0 0 0 1 0 0 0 0", "lead 0 0 0 2 0 0 0",
      "lead 0 0 0 0 0 0 0", "lead 0 0 0,1", "lead a b c", "lead 0 0 0 nan 0 0 0", "release me");
  ControlFrame wanted{}, before{};
  const ControlCommand command = apply_command(line, kSession, wanted);
  CAPTURE(line, command.problem);
  CHECK(command.kind == CommandKind::kRefused);
  CHECK_FALSE(command.problem.empty());
  CHECK(command.problem.find('\n') == std::string::npos);
  // wire structs have no padding: NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
  CHECK(std::memcmp(&wanted, &before, sizeof wanted) == 0);
}

TEST_CASE("command: who mistypes one is told all of them", "[servo]") {
  ControlFrame wanted{};
  CHECK(apply_command("pawse", kSession, wanted).problem ==
        "unknown command 'pawse'; known: status, status text, config, stop, clear-fault, arm, "
        "disarm, pause, resume, lead X Y Z, release, set stiffness|damping|rotational-stiffness|"
        "rotational-damping|time-scale|renderer|solver VALUE");
  CHECK(apply_command("status now", kSession, wanted).problem == "'status' takes nothing after it");
}

TEST_CASE("command: a renderer is had where the session has a tool and maps for it", "[servo]") {
  haptic::SessionConfig config;
  ControlFrame wanted{};
  config.tool.primitive = haptic::primitive::Sphere{};
  CHECK(apply_command("set renderer direct6", config, wanted).kind == CommandKind::kChange);
  const ControlCommand refused = apply_command("set renderer voxel", config, wanted);
  CHECK(refused.kind == CommandKind::kRefused);
  CHECK(refused.problem.find("[contact.voxel]") != std::string::npos);
  config.voxel.is_wanted = 1;
  // its proxy rotates, which needs a rotational spring
  CHECK(apply_command("set renderer voxel", config, wanted).kind == CommandKind::kRefused);
  apply_command("set stiffness 800 N/m", config, wanted);
  apply_command("set rotational-stiffness 1 N·m/rad", config, wanted);
  CHECK(apply_command("set renderer voxel", config, wanted).kind == CommandKind::kChange);
  CHECK(wanted.renderer == static_cast<uint32_t>(haptic::Renderer::kVoxel));
  CHECK(apply_command("set rotational-stiffness 0 N·m/rad", config, wanted).kind ==
        CommandKind::kRefused);
  CHECK(wanted.rotational_stiffness == 1);
}

TEST_CASE("command: the solver of a soft body is had where its renderer is in use", "[servo]") {
  using haptic::SoftSolver;
  haptic::SessionConfig config;
  config.tool.primitive = haptic::primitive::Sphere{};
  config.voxel.is_wanted = 1;
  ControlFrame wanted{};
  const auto solver = [&] { return haptic::soft_solver_of(wanted.solver); };
  const ControlCommand point = apply_command("set solver direct", config, wanted);
  CHECK(point.problem.find("'god-object3' has one of its own") != std::string::npos);
  CHECK(apply_command("set renderer direct6", config, wanted).kind == CommandKind::kChange);
  CHECK(solver() == SoftSolver::kDirect);
  // a proxy that turns needs its springs
  const ControlCommand still = apply_command("set solver penalty-dynamics", config, wanted);
  CHECK(still.problem.find("rotational-stiffness above zero") != std::string::npos);
  CHECK(solver() == SoftSolver::kDirect);
  apply_command("set stiffness 800 N/m", config, wanted);
  apply_command("set rotational-stiffness 1 N·m/rad", config, wanted);
  CHECK(apply_command("set solver penalty-dynamics", config, wanted).kind == CommandKind::kChange);
  CHECK(solver() == SoftSolver::kPenaltyDynamics);
  CHECK(apply_command("set stiffness 0 N/m", config, wanted).kind == CommandKind::kRefused);
  // another renderer begins with the solver of its own, or of the session's file
  CHECK(apply_command("set renderer voxel", config, wanted).kind == CommandKind::kChange);
  CHECK(solver() == SoftSolver::kQuasiStatic);
  CHECK(apply_command("set solver direct", config, wanted).kind == CommandKind::kChange);
  // direct needs none of them
  CHECK(apply_command("set stiffness 0 N/m", config, wanted).kind == CommandKind::kChange);
  CHECK(apply_command("set solver quasi-static", config, wanted).kind == CommandKind::kRefused);
  config.proxy.solver = SoftSolver::kDirect;
  CHECK(apply_command("set renderer voxel", config, wanted).kind == CommandKind::kChange);
  CHECK(solver() == SoftSolver::kDirect);
}

TEST_CASE("command: a simulated hand is led and released", "[servo]") {
  ControlFrame wanted{};
  wanted.revision = 3;
  CHECK(apply_command("lead 0.01 -0.02 3e-2", kSession, wanted).kind == CommandKind::kLead);
  CHECK(wanted.leading == 1);
  CHECK(wanted.revision == 4);
  CHECK(wanted.X_WT_intent.p == haptic::Vec3{0.01, -0.02, 0.03});
  CHECK(wanted.X_WT_intent.q == haptic::Quat{});
  // the order of the words is w x y z
  haptic::SessionConfig turning = kSession;
  turning.device.hand.inertia = 1e-4;
  turning.map.X_WB.q = haptic::Quat{1, 0, 0, 0};
  turning.map.X_HT.q = haptic::Quat{0, 1, 0, 0};
  CHECK(apply_command("lead 0 0 0 0.6 0 0.8 0", turning, wanted).kind == CommandKind::kLead);
  CHECK(wanted.X_WT_intent.q == haptic::Quat{0, 0.8, 0, 0.6});
  // without them, and of a handle that cannot turn: as the handle holds the tool at rest
  const haptic::Quat at_rest{0, 0, 1, 0};
  CHECK(apply_command("lead 0 0 0", turning, wanted).kind == CommandKind::kLead);
  CHECK(wanted.X_WT_intent.q == at_rest);
  turning.device.hand.inertia = 0;
  CHECK(apply_command("lead 0 0 0 0.6 0 0.8 0", turning, wanted).kind == CommandKind::kLead);
  CHECK(wanted.X_WT_intent.q == at_rest);
  CHECK(apply_command("release", kSession, wanted).kind == CommandKind::kLead);
  CHECK(wanted.leading == 0);
}

TEST_CASE("command: nobody leads a real hand, a recorded one, or none", "[servo]") {
  const std::string line = GENERATE(as<std::string>(), "lead 0 0 0", "release");
  haptic::SessionConfig config;
  const auto problem = [&] {
    ControlFrame wanted{};
    const ControlCommand command = apply_command(line, config, wanted);
    CHECK(command.kind == CommandKind::kRefused);
    CHECK(wanted.revision == 0);
    return command.problem;
  };
  config.device.kind = haptic::DeviceKind::kWoodenHaptics;
  CHECK(problem().find("a real one: nothing to lead") != std::string::npos);
  config.device.kind = haptic::DeviceKind::kReplay;
  CHECK(problem().find("a replay: nothing to lead") != std::string::npos);
  config.device.kind = haptic::DeviceKind::kSimulatedHand;
  config.device.hand.hand_stiffness = 0;
  CHECK(problem().find("hand_stiffness is 0") != std::string::npos);
}
