// SPDX-License-Identifier: GPL-3.0-or-later
// The force of a real session, tick by tick: a recorded hand on a wall.
#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <iomanip>
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

constexpr double kPressForce = 1.6;  // [N]; 2 mm at 800 N/m

/// A session whose recorded hand presses 2 mm into a block for `seconds`.
std::string write_press_session(const std::string& folder, double seconds) {
  std::ofstream csv(folder + "/press.csv");
  csv << "t_s,x_m,y_m,z_m\n" << std::setprecision(9);
  for (int i = 0; i <= static_cast<int>(seconds * 100); ++i) {
    const double t = 0.01 * i;
    csv << t << ",0,0," << std::max(0.041 - 0.01 * t, 0.038) << '\n';
  }
  const std::string path = folder + "/press.toml";
  std::ofstream(path) << R"([session]
name = "press"
realtime = true
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

using Frames = std::vector<ServoFrame>;

/// Appends every frame published since the last call, in order. Reading only the newest frame
/// (`latest`) would skip others: it must not be used once frames are being collected.
void collect(Watcher& watcher, Frames& frames) {
  for (ServoFrame frame; watcher.servo.next(frame);) frames.push_back(frame);
}

double force(const ServoFrame& frame) {
  return norm(frame.F_device_B.f);
}

/// Collects until the newest frame satisfies the condition.
template <typename Wanted>
bool collect_until(Watcher& watcher, Frames& frames, Wanted wanted) {
  return eventually([&] {
    collect(watcher, frames);
    return !frames.empty() && wanted(frames.back());
  });
}

/// The steady press, a while after the hand has come to rest.
bool is_pressing(const ServoFrame& frame) {
  return frame.tick > 1200 && std::fabs(force(frame) - kPressForce) < 1e-6;
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

/// A running session whose hand presses steadily, and its frames from then on.
struct Press {
  TemporaryRuntimeFolder folder;
  HapticdProcess hapticd;
  Watcher watcher;
  Frames frames;

  Press() : hapticd({write_press_session(folder.path(), 120)}, folder.path()), watcher("press") {
    REQUIRE(watcher.wait_for_all());
    REQUIRE(collect_until(watcher, frames, is_pressing));
    frames.erase(frames.begin(), frames.end() - 1);
  }
};

/// The beginning of a file: the whole of it where HAPTIC_TORTURE_SCALE is large.
void copy_lines(const std::string& from, const std::string& to, int most) {
  std::ifstream in(from);
  std::ofstream out(to);
  for (std::string line; most > 0 && std::getline(in, line); --most) out << line << '\n';
}

}  // namespace

TEST_CASE("chain: a hand feels k times depth in the real processes, and zero at the end") {
  Press press;
  auto& [folder, hapticd, watcher, frames] = press;
  const ServoFrame pressing = frames.back();
  CHECK(pressing.F_device_B.f.z == Approx(kPressForce).epsilon(1e-9));
  CHECK(pressing.F_device_B.f.x == 0);
  CHECK((pressing.device.flags & kDeviceOpenLoop) != 0);
  CHECK(pressing.X_WG.p.z > 0.04);
  hapticd.send(SIGTERM);
  CHECK(hapticd.exit_code() == 0);
  collect(watcher, frames);
  REQUIRE(frames.size() > 1);
  CHECK((frames.back().flags & kServoStopped) != 0);
  CHECK(frames.back().F_device_B == Wrench{});
  CHECK(force(frames[frames.size() - 2]) > 0);
  check_every_tick(watcher, frames);
  CHECK(watcher.servo.header()->state == static_cast<uint32_t>(SegmentState::kDead));
}

TEST_CASE("chain: the 2 kHz recording of a human hand loses no sample in real time") {
  const auto whole = test::find_data("tue-1dof-bilateral/m2_question1c_rigid.csv");
  if (!whole) return;
  const TemporaryRuntimeFolder folder;
  const std::string recording = folder.path() + "/hand.csv";
  copy_lines(*whole, recording, static_cast<int>(1500 * std::max(test::torture_scale(), 1.0)));
  const std::string config = test::from_source("configs/lever.toml");
  HapticdProcess hapticd({config, "--session", "lever", "--replay", recording}, folder.path());
  Watcher watcher("lever");
  Frames frames;
  REQUIRE(collect_until(watcher, frames, has_ended));
  check_every_tick(watcher, frames);

  SessionConfig lever = load_config(config);
  use_trace(lever, recording);
  const auto samples = load_hand_trace(lever.device.replay).samples;
  size_t used = 0;
  for (const ServoFrame& f : frames) {
    if (has_ended(f)) break;
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
