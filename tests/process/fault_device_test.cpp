// SPDX-License-Identifier: GPL-3.0-or-later
// Forces on the hand when the device lies or is silent, and when the machine is short of memory or
// time.
#include <algorithm>
#include <fstream>
#include <iomanip>

#include "device-io/emulator/fault_order.h"
#include "proto/os/queued_order.h"
#include "tests/process/faulted_session.h"
#include "tests/process/hapt_command.h"

namespace haptic {
namespace {

using namespace test;

constexpr double kZero = 5e-3;  // [N], half a step of the currents

/// A recorded hand that presses 2 mm into a block for two seconds and is then, one sample later, a
/// metre beside it.
std::string write_jump_session(const std::string& folder) {
  std::ofstream csv(folder + "/jump.csv");
  csv << "t_s,x_m,y_m,z_m\n" << std::setprecision(9);
  for (int i = 0; i <= 6000; ++i) {
    const double t = 0.001 * i;
    csv << t << ',' << (t < 2 ? 0 : 1) << ",0," << (t < 1 ? 0.041 - 0.003 * t : 0.038) << '\n';
  }
  std::string path = folder + "/jump.toml";
  std::ofstream(path) << R"([session]
name = "jump"
realtime = true
[device]
kind = "replay"
[device.replay]
path = "jump.csv"
resampling = "hold"
[safety]
armed_at_start = true
soft_start = "0.1 s"
[[object]]
name = "block"
primitive = "box"
extent = ["80 mm", "80 mm", "80 mm"]
)";
  return path;
}

}  // namespace

TEST_CASE("fault: a jump of two thirds of a metre closes the force until the fault is cleared") {
  if (!programs_are_built()) return;
  FaultedSession s;
  const FaultOutcome outcome = s.inject(FaultKind::kPoseJump);
  CHECK(outcome.zero_after_ns);
  // the proxy has not moved around the block: the wall pushes up as before
  CHECK(s.is_pressing());
}

TEST_CASE("fault: of a device with six motors torque ends as force does, and both come back") {
  if (!programs_are_built()) return;
  FaultedSession s(false, true);
  for (const FaultKind kind :
       {FaultKind::kTurnJump, FaultKind::kContactNaN, FaultKind::kDeviceFrozen}) {
    CHECK(s.inject(kind).zero_after_ns);
  }
  s.inject(FaultKind::kContactKill);
  s.inject(FaultKind::kContactLies);
  CHECK(s.is_pressing());
  CHECK(norm(s.session.records().back().torque_B) > 5e-3);
}

TEST_CASE("fault: encoders that go on lying leave the force closed") {
  if (!programs_are_built()) return;
  FaultedSession s;
  const auto jumped = [](const EmulatorRecord& r) { return r.answered[0] > kJumpCounts[0] / 2; };
  REQUIRE(send_order(s.session.emulator().pid(), static_cast<int>(EmulatorFault::kJump)));
  REQUIRE(s.session.wait_until(
      [&] {
        const auto& all = s.session.records();
        return std::count_if(all.begin(), all.end(), jumped) > 200;
      },
      test::kPatienceNs));
  const auto& all = s.session.records();
  const auto first = std::find_if(all.begin(), all.end(), jumped);
  REQUIRE(first != all.begin());
  CHECK(std::prev(first)->force_B.z > 1);
  CHECK(std::all_of(first, all.end(),
                    [](const EmulatorRecord& r) { return norm(r.force_B) <= kZero; }));
}

TEST_CASE("fault: a device that is frozen, late or noisy is found, and zero until it is cleared") {
  if (!programs_are_built()) return;
  FaultedSession s;
  const FaultKind kind = GENERATE(FaultKind::kDeviceFrozen, FaultKind::kDeviceOldFirst,
                                  FaultKind::kDeviceDelayed, FaultKind::kDeviceNoise);
  const FaultOutcome outcome = s.inject(kind);
  CHECK(outcome.zero_after_ns);
  CHECK(s.is_pressing());
  // the reason is reported once
  const char* reason = kind == FaultKind::kDeviceNoise ? "an encoder of the device is noisy"
                                                       : "answers do not match the requests";
  std::ifstream said(s.folder.path() + "/said");
  const std::string text((std::istreambuf_iterator<char>(said)), {});
  CAPTURE(text);
  CHECK(text.find(reason) != text.npos);
}

TEST_CASE("fault: a jump of a whole metre, as no arm can do it, is a fault with zero force") {
  if (!programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({write_jump_session(folder.path())}, folder.path());
  Watcher watcher("jump");
  std::vector<ServoFrame> frames;
  REQUIRE(eventually([&] {
    for (ServoFrame f; watcher.servo.next(f);) frames.push_back(f);
    return !frames.empty() && frames.back().device.X_BH.p.x > 0.5 &&
           frames.back().tick > frames.front().tick + 2500;
  }));
  const auto at = std::find_if(frames.begin(), frames.end(),
                               [](const ServoFrame& f) { return f.device.X_BH.p.x > 0.5; });
  REQUIRE(at != frames.begin());
  CHECK(norm(at->device.X_BH.p - std::prev(at)->device.X_BH.p) == Approx(1));
  // slightly earlier: samples next to the jump have a velocity that closes the force by itself
  REQUIRE(at - frames.begin() > 100);
  CHECK(norm((at - 100)->F_device_B.f) > 1);
  CHECK(at->fault == static_cast<uint32_t>(Fault::kPoseJump));
  // the implausible sample is not followed
  CHECK(at->X_WT.p.x == Approx(0).margin(1e-9));
  CHECK(std::all_of(at, frames.end(), [](const ServoFrame& f) {
    return f.F_device_B == Wrench{} && (f.flags & kServoFault) != 0;
  }));
  CHECK(eventually([&] { return hapticd.said("the pose of the device jumped"); }));
}

TEST_CASE("fault: a device that is silent gets zero on its return, then a soft start") {
  if (!programs_are_built()) return;
  FaultedSession s;
  s.inject(FaultKind::kDeviceSilent);
  CHECK(s.is_pressing());
}

TEST_CASE("fault: short of memory or of time, the force stays within its limits") {
  if (!programs_are_built()) return;
  FaultedSession s;
  const FaultKind kind = GENERATE(FaultKind::kMemory, FaultKind::kBusy);
  const FaultOutcome outcome = s.inject(kind);
  if (!outcome.left_out.empty()) WARN("SKIPPED: " << outcome.left_out);
  CHECK(s.is_pressing());
}

TEST_CASE("fault: hapt torture does a handful of faults and accounts for every sample") {
  if (!programs_are_built()) return;
  const TemporaryFolder folder;
  const test::Ran ran = test::hapt("torture --minutes 0.1 --seed 2 --json", folder.path());
  CAPTURE(ran.output);
  // in six seconds the goal of 100 faults per minute may be missed
  CHECK((ran.code == 0 || ran.code == 1));
  CHECK(test::has(ran.output, "\"case\": \"contact: kill -9\""));
  CHECK(test::figure(ran.output, "not recorded, unexplained") == 0);
  // without real-time rights and under load, tick times are arbitrary
  CHECK(test::figure(ran.output, "recorded") > 100);
}

TEST_CASE("fault: hapt torture says in one line what it cannot do") {
  if (!programs_are_built()) return;
  const TemporaryFolder folder;
  const test::Ran words = test::hapt("torture --minutes never", folder.path());
  CHECK(words.code == 2);
  CHECK(test::lines(words.output) == 1);
  const test::Ran output = test::hapt("torture -o /no/such/folder/x.mcap", folder.path());
  CHECK(output.code == 1);
  CHECK(test::lines(output.output) == 1);
}

}  // namespace haptic
