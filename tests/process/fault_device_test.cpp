// SPDX-License-Identifier: GPL-3.0-or-later
// Forces on the hand when the device lies or is silent, and when the machine is short of memory or
// time: what the driver finds and the servo's step does, once through the real programs.
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "tests/process/faulted_session.h"
#include "tests/process/hapt_command.h"
#include "tests/support/torture_scale.h"

namespace haptic {
namespace {

using namespace test;

/// Whether its programs have said that.
bool has_said(const FaultedSession& s, const std::string& words) {
  std::ifstream said(s.folder.path() + "/said");
  const std::string text((std::istreambuf_iterator<char>(said)), {});
  return has(text, words);
}

}  // namespace

TEST_CASE(
    "fault: a device that is frozen or noisy is zero until it is cleared, a silent one back") {
  FaultedSession s;
  CHECK(s.inject(FaultKind::kDeviceFrozen).zero_after_ns);
  CHECK(s.is_pressing());
  CHECK(has_said(s, "answers do not match the requests"));
  // of a pose that jumps aside the proxy does not move around the block
  for (const FaultKind kind :
       {FaultKind::kDeviceOldFirst, FaultKind::kDeviceDelayed, FaultKind::kPoseJump}) {
    CAPTURE(info_of(kind).name);
    CHECK(s.inject(kind).zero_after_ns);
    CHECK(s.is_pressing());
  }
  CHECK(s.inject(FaultKind::kDeviceNoise).zero_after_ns);
  CHECK(s.is_pressing());
  CHECK(has_said(s, "an encoder of the device is noisy"));
  // zero is the first that it reads on its return, then a soft start
  s.inject(FaultKind::kDeviceSilent);
  CHECK(s.is_pressing());
}

TEST_CASE("fault: of a device with six motors torque ends as force does, and both come back") {
  FaultedSession s(false, true);
  for (const FaultKind kind :
       {FaultKind::kTurnJump, FaultKind::kContactNaN, FaultKind::kDeviceFrozen}) {
    CAPTURE(info_of(kind).name);
    CHECK(s.inject(kind).zero_after_ns);
  }
  CHECK(has_said(s, "the pose of the device jumped"));
  s.inject(FaultKind::kContactKill);
  s.inject(FaultKind::kContactLies);
  CHECK(s.is_pressing());
  CHECK(norm(s.session.records().back().torque_B) > 5e-3);
}

TEST_CASE("fault: short of memory or of time, the force stays within its limits") {
  FaultedSession s;
  if (torture_scale() > 1) {
    for (const FaultKind kind : {FaultKind::kMemory, FaultKind::kBusy}) {
      const FaultOutcome outcome = s.inject(kind);
      if (!outcome.left_out.empty()) WARN("SKIPPED: " << outcome.left_out);
      CHECK(s.is_pressing());
    }
    return;
  }
  if (find_on_path("stress-ng").empty()) {
    WARN("SKIPPED: stress-ng is not installed");
    return;
  }
  // half of the memory takes seconds: with a larger HAPTIC_TORTURE_SCALE. Here a tenth and all
  // cores, in each attempt
  std::unique_ptr<SessionProcess> hog;
  const auto start_hog = [&] {
    if (hog && !hog->exit_code()) return;
    hog = std::make_unique<SessionProcess>(
        "stress-ng",
        std::vector<std::string>{"--vm", "1", "--vm-bytes", "512m", "--cpu", "2", "--timeout", "1s",
                                 "--temp-path", s.folder.path()},
        s.folder.path() + "/said-by-stress-ng");
  };
  // until it has ended: whatever was felt meanwhile was within the limits too
  FaultOutcome outcome;
  do {
    outcome = s.inject(FaultKind::kServoPause, start_hog);
  } while (outcome.violations.empty() && !hog->exit_code());
  CHECK(s.session.wait_until([&] { return hog->exit_code().has_value(); }, kPatienceNs));
  CHECK(hog->exit_code() == 0);
  CHECK(s.is_pressing());
}

TEST_CASE("fault: hapt torture does a handful of faults and accounts for every sample") {
  const TemporaryFolder folder;
  // with bodies the hand holds one, from before the first fault on
  const std::string with = GENERATE("", "--bodies ", "--given ");
  const Ran ran = hapt("torture " + with + "--minutes 0.05 --seed 4 --json", folder.path());
  CAPTURE(with, ran.output);
  // in three seconds the goal of 100 faults per minute may be missed
  CHECK((ran.code == 0 || ran.code == 1));
  CHECK(has(ran.output, "\"case\": \"contact: kill -9\""));
  CHECK(figure(ran.output, "not recorded, unexplained") == 0);
  // without real-time rights and under load, tick times are arbitrary
  CHECK(figure(ran.output, "recorded") > 100);
}

}  // namespace haptic
