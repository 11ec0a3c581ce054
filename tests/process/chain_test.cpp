// SPDX-License-Identifier: GPL-3.0-or-later
// The force of a real session, tick by tick: a recorded hand on a wall.
#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <vector>

#include "proto/config/config.h"
#include "proto/config/devices.h"
#include "proto/log/hand_trace.h"
#include "proto/os/programs.h"
#include "tests/process/hapticd_process.h"
#include "tests/process/watcher.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/torture_scale.h"

namespace haptic {
namespace {

using test::eventually;
using test::HapticdProcess;
using test::TemporaryRuntimeFolder;
using test::Watcher;

using Frames = std::vector<ServoFrame>;

/// Appends every frame published since the last call, in order. Reading only the newest frame
/// (`latest`) would skip others: it must not be used once frames are being collected.
void collect(Watcher& watcher, Frames& frames) {
  for (ServoFrame frame; watcher.servo.next(frame);) frames.push_back(frame);
}

/// Collects until the newest frame satisfies the condition.
template <typename Wanted>
bool collect_until(Watcher& watcher, Frames& frames, Wanted wanted) {
  return eventually([&] {
    collect(watcher, frames);
    return !frames.empty() && wanted(frames.back());
  });
}

/// Whether the recording is over.
bool has_ended(const ServoFrame& frame) {
  return (frame.device.flags & kDeviceEnded) != 0;
}

/// Checks that every grid point is a frame or a counted skip and that the watcher missed none.
void check_every_tick(const Watcher& watcher, const Frames& frames) {
  CHECK(watcher.servo.generation() == 1);
  CHECK(watcher.servo.lost() == 0);
  for (size_t k = 1; k < frames.size(); ++k) {
    const uint64_t skipped = frames[k].skipped - frames[k - 1].skipped;
    REQUIRE(frames[k].tick == frames[k - 1].tick + 1 + skipped);
  }
}

/// The beginning of a file: more of it with a larger HAPTIC_TORTURE_SCALE.
void copy_lines(const std::string& from, const std::string& to, int most) {
  std::ifstream in(from);
  std::ofstream out(to);
  for (std::string line; most > 0 && std::getline(in, line); --most) out << line << '\n';
}

/// Checks that each frame is exactly the sample of its grid point, up to the end of the recording.
void check_every_sample(const Frames& frames, const std::vector<DeviceState>& samples) {
  size_t used = 0;
  for (const ServoFrame& f : frames) {
    if (has_ended(f)) break;
    ++used;
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

}  // namespace

TEST_CASE("chain: a 2 kHz recording loses no sample, feels k times depth, and zero at the end") {
  const TemporaryRuntimeFolder folder;
  const std::string config = test::from_source("configs/lever.toml");
  // half a second, at whose end the hand presses 2.5 mm into the wall at x = -2 mm
  const std::string recording = folder.path() + "/hand.csv";
  const int lines =
      2 + static_cast<int>(2000 * (std::clamp(test::torture_scale(), 1.0, 4.0) - 0.5));
  copy_lines(test::from_source("configs/lever.csv"), recording, lines);
  HapticdProcess hapticd({config, "--session", "lever", "--replay", recording}, folder.path());
  Watcher watcher("lever");
  Frames frames;
  REQUIRE(collect_until(watcher, frames, [](const ServoFrame& f) {
    // on a busy machine the contacts may just be too old
    return has_ended(f) && f.fade == 1 && (f.flags & (kServoSoftStart | kServoSlewing)) == 0;
  }));
  check_every_tick(watcher, frames);
  SessionConfig lever = load_config(config);
  use_trace(lever, recording);
  check_every_sample(frames, load_hand_trace(lever.device.replay).samples);

  const ServoFrame pressing = frames.back();
  CHECK(pressing.F_device_B.f.x == Approx(800 * (-2e-3 - pressing.X_WT.p.x)).epsilon(1e-9));
  CHECK(pressing.F_device_B.f.x > 1);
  CHECK(pressing.F_device_B.f.z == 0);
  CHECK((pressing.device.flags & kDeviceOpenLoop) != 0);
  CHECK(pressing.X_WG.p.x > -2e-3);
  hapticd.send(SIGTERM);
  CHECK(hapticd.exit_code() == 0);
  collect(watcher, frames);
  CHECK((frames.back().flags & kServoStopped) != 0);
  CHECK(frames.back().F_device_B == Wrench{});
  const ServoFrame& last = frames[frames.size() - 2];
  CHECK((norm(last.F_device_B.f) > 0 || (last.flags & kServoStale) != 0));
  check_every_tick(watcher, frames);
  CHECK(watcher.servo.header()->state == static_cast<uint32_t>(SegmentState::kDead));
}

}  // namespace haptic
