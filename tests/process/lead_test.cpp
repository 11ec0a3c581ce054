// SPDX-License-Identifier: GPL-3.0-or-later
// A person leads the simulated hand of a real session.
#include <catch2/catch.hpp>

#include "proto/wire/proxy_solver.h"
#include "tests/process/hapt_command.h"
#include "tests/process/hapticd_process.h"
#include "tests/process/programs.h"
#include "tests/process/watcher.h"
#include "tests/support/data.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::eventually;
using test::hapt;
using test::Ran;
using test::RunningSession;
using test::Watcher;

std::string config(const std::string& name) {
  return test::from_source("configs/" + name);
}

bool is_led(Watcher& watcher) {
  watcher.servo.latest(watcher.servo_frame);
  return (watcher.servo_frame.device.flags & kDeviceLed) != 0;
}

}  // namespace

TEST_CASE("hapt lead: the tool is led to a place in free space, and back") {
  RunningSession session(config("plane.toml"), "led");
  auto& [folder, hapticd, watcher] = session;
  test::ProgramProcess leader("hapt", {"lead", "-0.02", "0.1", "80 mm", "--for", "1 min"},
                              folder.path());
  const Vec3 place_W{-0.02, 0.1, 0.08};
  REQUIRE(eventually([&] { return is_led(watcher); }));
  CHECK(eventually([&] {
    watcher.servo.latest(watcher.servo_frame);
    const Twist& V_WT = watcher.servo_frame.V_WT;
    return norm(watcher.servo_frame.X_WT.p - place_W) < 1e-3 && norm(V_WT.v) < 1e-2;
  }));
  watcher.control.latest(watcher.control_frame);
  CHECK(watcher.control_frame.leading == 1);
  CHECK(watcher.control_frame.X_WT_intent.p == place_W);
  const Ran status = hapt("status", folder.path());
  INFO(status.output);
  CHECK(test::has(status.output, "hand       led to (-0.0200, 0.1000, 0.0800) m\n"));
  // the log has a line for the beginning, not sixty a second
  CHECK(hapticd.log().find("somebody leads") == hapticd.log().rfind("somebody leads"));

  // whoever leads stops, and hapticd with it: the servo notices by itself
  const int signal = GENERATE(SIGSTOP, SIGKILL);
  leader.send(signal);
  if (signal == SIGSTOP) hapticd.send(SIGSTOP);
  const int64_t stopped_ns = now_ns();
  bool was_led = true;
  int64_t ended_ns = 0;
  // on a busy machine a gap between two commands may have ended it for a while: the last end counts
  CHECK(eventually([&] {
    while (watcher.servo.next(watcher.servo_frame)) {
      const DeviceState& device = watcher.servo_frame.device;
      const bool led_now = (device.flags & kDeviceLed) != 0;
      if (was_led && !led_now) ended_ns = device.t_ns;
      was_led = led_now;
    }
    return !was_led && now_ns() - stopped_ns > 2 * kLeadNs;
  }));
  // the newest command that hapticd has published, before anybody goes on
  while (watcher.control.next(watcher.control_frame)) {
  }
  leader.send(SIGCONT);
  leader.send(SIGKILL);
  hapticd.send(SIGCONT);
  const int64_t last_ns = watcher.control_frame.intent_t_ns;
  CHECK(ended_ns >= last_ns + kLeadNs);
  CHECK(eventually([&] {
    watcher.servo.latest(watcher.servo_frame);
    return norm(watcher.servo_frame.X_WT.p - place_W) > 0.01;
  }));
  CHECK(eventually([&] {
    watcher.control.latest(watcher.control_frame);
    return watcher.control_frame.leading == 0;
  }));
}

TEST_CASE("hapt set solver: of a body, while it runs") {
  RunningSession session(config("peg-in-hole.toml"), "peg");
  auto& [folder, hapticd, watcher] = session;
  const auto solver = [&] { return hapt("status --json", folder.path()).output; };
  CHECK(test::has(solver(), "\"solver\": \"quasi-static\", \"led\": false"));
  for (const std::string_view name : kSoftSolverNames) {
    const Ran ran = hapt("set solver " + std::string(name), folder.path());
    INFO(ran.output);
    CHECK(ran.code == 0);
    CHECK(test::has(solver(), "\"solver\": \"" + std::string(name) + "\""));
  }
  const Ran wrong = hapt("set solver quick", folder.path());
  CHECK(wrong.code == 2);
  CHECK(test::lines(wrong.output) == 1);
}

}  // namespace haptic
