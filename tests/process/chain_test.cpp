// SPDX-License-Identifier: GPL-3.0-or-later
// The force of a real session, tick by tick: a recorded hand on a wall, with and without faults.
#include <catch2/catch.hpp>
#include <fstream>
#include <iomanip>
#include <vector>

#include "proto/hand_trace.h"
#include "tests/process/hapticd_process.h"
#include "tests/process/watcher.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::eventually;
using test::HapticdProcess;
using test::TemporaryRuntimeFolder;
using test::Watcher;

constexpr double kPressForce = 1.6;  // 2 mm at 800 N/m

/// A session whose recorded hand presses 2 mm into a block for `seconds`.
std::string write_press_session(const std::string& folder, double seconds) {
  std::ofstream csv(folder + "/press.csv");
  csv << "t_s,x_m,y_m,z_m\n" << std::setprecision(9);
  for (int i = 0; i <= static_cast<int>(seconds * 100); ++i) {
    const double t = 0.01 * i;
    csv << t << ",0,0," << (t < 1 ? 0.041 - 0.003 * t : 0.038) << '\n';
  }
  const std::string path = folder + "/press.toml";
  std::ofstream(path) << R"([session]
name = "press"
realtime = false
[device]
kind = "replay"
[device.replay]
path = "press.csv"
[coupling]
stiffness = "800 N/m"
[safety]
soft_start = "0.1 s"
[[object]]
name = "block"
primitive = "box"
extent = ["80 mm", "80 mm", "80 mm"]
)";
  return path;
}

/// Every frame there is, in order.
std::vector<ServoFrame> drain(Watcher& watcher) {
  std::vector<ServoFrame> frames;
  for (ServoFrame frame; watcher.servo.next(frame);) frames.push_back(frame);
  return frames;
}

double force(const ServoFrame& frame) {
  return norm(frame.F_device_B.f);
}

/// Waits for the steady press: a while after the hand has come to rest.
bool presses(Watcher& watcher) {
  return eventually([&] {
    watcher.servo.latest(watcher.servo_frame);
    return watcher.servo_frame.tick > 1200 &&
           std::fabs(force(watcher.servo_frame) - kPressForce) < 1e-6;
  });
}

/// Largest change of force per tick that passed, rising and falling.
struct Steps {
  double rise = 0, fall = 0;
};
Steps largest_steps(const std::vector<ServoFrame>& frames) {
  Steps steps;
  for (size_t k = 1; k < frames.size(); ++k) {
    const auto ticks = static_cast<double>(frames[k].tick - frames[k - 1].tick);
    const double change = (force(frames[k]) - force(frames[k - 1])) / ticks;
    steps.rise = std::max(steps.rise, change);
    steps.fall = std::max(steps.fall, -change);
  }
  return steps;
}

}  // namespace

TEST_CASE("chain: a recorded hand feels k times depth in the real processes") {
  if (!test::programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({write_press_session(folder.path(), 60)}, folder.path());
  Watcher watcher("press");
  INFO(hapticd.log());
  REQUIRE(watcher.wait_for_all());
  REQUIRE(presses(watcher));
  const ServoFrame& f = watcher.servo_frame;
  CHECK(f.F_device_B.f.z == Approx(kPressForce).epsilon(1e-9));
  CHECK(f.F_device_B.f.x == 0);
  CHECK((f.device.flags & kDeviceOpenLoop) != 0);
  CHECK(f.X_WG.p.z > 0.04);
}

TEST_CASE("chain: contact is killed in mid-press, force holds, fades and returns through a ramp") {
  if (!test::programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({write_press_session(folder.path(), 120)}, folder.path());
  Watcher watcher("press");
  REQUIRE(watcher.wait_for_all());
  REQUIRE(presses(watcher));
  drain(watcher);

  kill(test::writer_of(watcher.contact), SIGKILL);
  REQUIRE(eventually([&] {
    watcher.contact.latest(watcher.contact_set);
    return watcher.contact.generation() == 2;
  }));
  REQUIRE(presses(watcher));
  std::vector<ServoFrame> frames = drain(watcher);
  INFO(hapticd.log());
  // the servo never stopped: whatever is not a frame is a counted skip
  CHECK(watcher.servo.generation() == 1);
  CHECK(watcher.servo.lost() == 0);
  // down over 50 ms and up over 50 ms: never a step (at most 1.6 N / 50 a tick)
  const Steps steps = largest_steps(frames);
  CHECK(steps.rise <= kPressForce / 50 * 1.01);
  CHECK(steps.fall <= kPressForce / 50 * 1.01);
}

TEST_CASE("chain: a contact that hangs leaves no stale wall, and its return is a ramp") {
  if (!test::programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({write_press_session(folder.path(), 120)}, folder.path());
  Watcher watcher("press");
  REQUIRE(watcher.wait_for_all());
  REQUIRE(presses(watcher));
  drain(watcher);

  const pid_t contact = test::writer_of(watcher.contact);
  kill(contact, SIGSTOP);
  std::vector<ServoFrame> frames;
  CHECK(eventually([&] {
    for (const ServoFrame& f : drain(watcher)) frames.push_back(f);
    return !frames.empty() && (frames.back().flags & kServoStale) != 0;
  }));
  CHECK(force(frames.back()) == 0);
  kill(contact, SIGCONT);
  CHECK(eventually([&] {
    for (const ServoFrame& f : drain(watcher)) frames.push_back(f);
    return std::fabs(force(frames.back()) - kPressForce) < 1e-6;
  }));

  // held in full within the hold, zero after hold and fade, whatever the machine did meanwhile
  for (const ServoFrame& f : frames) {
    const auto answered = static_cast<int64_t>(f.contact_tick);
    const int64_t age = static_cast<int64_t>(f.tick) - answered;
    CAPTURE(f.tick, age, force(f), f.fade);
    if (age > 150) CHECK(force(f) == 0);
    if ((f.flags & (kServoFading | kServoStale | kServoReopening)) == 0) {
      CHECK(force(f) == Approx(kPressForce).epsilon(1e-9));
    }
  }
  const Steps steps = largest_steps(frames);
  CHECK(steps.rise <= kPressForce / 50 * 1.01);
  CHECK(steps.fall <= kPressForce / 50 * 1.01);
}

TEST_CASE("chain: SIGTERM under load ends with a zero wrench") {
  if (!test::programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({write_press_session(folder.path(), 60)}, folder.path());
  Watcher watcher("press");
  REQUIRE(watcher.wait_for_all());
  REQUIRE(presses(watcher));
  hapticd.send(SIGTERM);
  CHECK(hapticd.exit_code() == 0);
  const std::vector<ServoFrame> frames = drain(watcher);
  REQUIRE(frames.size() > 1);
  CHECK((frames.back().flags & kServoStopped) != 0);
  CHECK(frames.back().F_device_B == Wrench{});
  CHECK(force(frames[frames.size() - 2]) > 0);
  CHECK(watcher.servo.header()->state == static_cast<uint32_t>(SegmentState::kDead));
}

TEST_CASE("chain: the 2 kHz recording of a human hand loses no sample in real time") {
  if (!test::programs_are_built()) return;
  const auto recording = test::find_data("tue-1dof-bilateral/m2_question1c_rigid.csv");
  if (!recording) return;
  const TemporaryRuntimeFolder folder;
  const std::string config = std::string(HAPTIC_SOURCE_DIR) + "/configs/lever.toml";
  HapticdProcess hapticd({config, "--session", "lever", "--replay", *recording}, folder.path());
  Watcher watcher("lever");
  std::vector<ServoFrame> frames;
  CHECK(eventually([&] {
    for (const ServoFrame& f : drain(watcher)) frames.push_back(f);
    return !frames.empty() && (frames.back().device.flags & kDeviceEnded) != 0;
  }));
  CHECK(watcher.servo.lost() == 0);

  SessionConfig lever = load_config(config);
  use_trace(lever, *recording);
  const auto samples = load_hand_trace(lever.device.replay).samples;
  size_t used = 0;
  for (const ServoFrame& f : frames) {
    if ((f.device.flags & kDeviceEnded) != 0) break;
    ++used;
    // each frame is exactly the sample of its grid point
    const uint64_t sample = f.tick - frames.front().tick;
    REQUIRE(sample < samples.size());
    REQUIRE(f.device.X_BH.p == samples[sample].X_BH.p);
  }
  const ServoFrame& ended = frames[used];
  const uint64_t covered = ended.tick - frames.front().tick;
  const uint64_t beyond = covered > samples.size() ? covered - samples.size() : 0;
  const uint64_t skipped = ended.skipped - frames.front().skipped - beyond;
  CHECK(used + skipped == samples.size());
}

}  // namespace haptic
