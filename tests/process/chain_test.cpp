// SPDX-License-Identifier: GPL-3.0-or-later
// The force of a real session, tick by tick: a recorded hand on a wall, with and without faults.
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
#include "tests/process/programs.h"
#include "tests/process/watcher.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

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
    csv << t << ",0,0," << (t < 1 ? 0.041 - 0.003 * t : 0.038) << '\n';
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

bool has(const ServoFrame& frame, uint32_t flags) {
  return (frame.flags & flags) != 0;
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

/// The first frame with a flag, which must exist.
const ServoFrame& first(const Frames& frames, uint32_t flags) {
  const auto found = std::find_if(frames.begin(), frames.end(),
                                  [&](const ServoFrame& f) { return has(f, flags); });
  REQUIRE(found != frames.end());
  return *found;
}

double least_force(const Frames& frames) {
  double least = kPressForce;
  for (const ServoFrame& f : frames) least = std::min(least, force(f));
  return least;
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

/// Checks a steady press, whatever happens to contact and the machine: full force while contacts
/// are younger than the shortest hold, zero once they are older than the longest hold plus fade,
/// and no step: down and up over 50 ms each, at most 1.6 N / 50 per tick.
void check_press(const Frames& frames) {
  constexpr double kMinHold = 20, kMaxHold = 100, kFade = 50;  // [ticks]
  constexpr double kLargestStep = kPressForce / kFade * 1.01;
  for (size_t k = 0; k < frames.size(); ++k) {
    const ServoFrame& f = frames[k];
    const double age = static_cast<double>(static_cast<int64_t>(f.tick - f.contact_tick));
    CAPTURE(f.tick, age, force(f), f.fade, f.flags);
    REQUIRE(force(f) == Approx(kPressForce * f.fade).epsilon(1e-9).margin(1e-12));
    REQUIRE(f.fade <= std::clamp((kMaxHold + kFade - age) / kFade, 0.0, 1.0) + 1e-9);
    if (has(f, kServoStale)) REQUIRE(f.fade == 0);
    if (!has(f, kServoStale | kServoReopening)) {
      REQUIRE(f.fade >= std::min(1.0, (kMinHold + kFade - age) / kFade) - 1e-9);
      if (!has(f, kServoFading)) REQUIRE(f.fade == 1);
    }
    if (k == 0) continue;
    const auto ticks = static_cast<double>(f.tick - frames[k - 1].tick);
    REQUIRE(std::fabs(force(f) - force(frames[k - 1])) <= kLargestStep * ticks);
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

/// Delays the start of a restarted contact by `pause` seconds.
void restart_contact_slowly(const test::Programs& programs, const std::string& pause) {
  // the last argument is the generation; exec keeps the pid and the inherited descriptors
  programs.replace("haptic-contact",
                   "case \"$*\" in *--spare-fd*) exit 1;; esac\n"
                   "for generation do :; done\n[ \"$generation\" = 1 ] || sleep " +
                       pause + "\nexec '" + (test::program_folder() / "haptic-contact").string() +
                       "' \"$@\"");
}

/// Kills contact during a press and collects until the servo presses on its successor's answers.
/// Returns the last tick before the kill.
uint64_t kill_contact(Watcher& watcher, Frames& frames) {
  collect(watcher, frames);
  const uint64_t before = frames.back().tick;
  const auto killed = static_cast<uint64_t>(test::writer_of(watcher.contact));
  kill(static_cast<pid_t>(killed), SIGKILL);
  REQUIRE(eventually([&] {
    collect(watcher, frames);
    return !test::is_alive(killed);
  }));
  collect(watcher, frames);
  // only the successor can answer a later frame
  const uint64_t dead = frames.back().tick;
  REQUIRE(collect_until(watcher, frames, [&](const ServoFrame& f) {
    return f.contact_tick > dead && is_pressing(f);
  }));
  // and it continues
  const uint64_t back = frames.back().tick;
  REQUIRE(collect_until(watcher, frames, [&](const ServoFrame& f) {
    return f.tick >= back + 100 && is_pressing(f);
  }));
  watcher.contact.latest(watcher.contact_set);
  CHECK(watcher.contact.generation() > 1);
  return before;
}

}  // namespace

TEST_CASE("chain: a recorded hand feels k times depth in the real processes") {
  if (!test::programs_are_built()) return;
  Press press;
  auto& [folder, hapticd, watcher, frames] = press;
  const ServoFrame& f = frames.back();
  CHECK(f.F_device_B.f.z == Approx(kPressForce).epsilon(1e-9));
  CHECK(f.F_device_B.f.x == 0);
  CHECK((f.device.flags & kDeviceOpenLoop) != 0);
  CHECK(f.X_WG.p.z > 0.04);
}

TEST_CASE("chain: contact is killed in mid-press, force holds, fades and returns through a ramp") {
  if (!test::programs_are_built()) return;
  const test::TemporaryFolder other;
  const test::Programs programs(other.path());
  restart_contact_slowly(programs, "0.3");
  Press press;
  auto& [folder, hapticd, watcher, frames] = press;
  const uint64_t killed_at = kill_contact(watcher, frames);
  INFO(hapticd.log());

  check_every_tick(watcher, frames);
  check_press(frames);
  // all frames were seen, in order, and the force was absent as long as contact
  CHECK(frames.size() > 300);
  const ServoFrame& fading = first(frames, kServoFading);
  const ServoFrame& stale = first(frames, kServoStale);
  const ServoFrame& reopening = first(frames, kServoReopening);
  CHECK(killed_at < fading.tick);
  CHECK(fading.tick < stale.tick);
  CHECK(stale.tick < reopening.tick);
  CHECK(reopening.tick >= killed_at + 300);
  CHECK(least_force(frames) == 0);
  CHECK(force(frames.back()) == Approx(kPressForce).epsilon(1e-9));
}

TEST_CASE("chain: contact is killed in mid-press and back at once, the hand feels no step") {
  if (!test::programs_are_built()) return;
  Press press;
  auto& [folder, hapticd, watcher, frames] = press;
  kill_contact(watcher, frames);
  INFO(hapticd.log());

  check_every_tick(watcher, frames);
  check_press(frames);
  CHECK(frames.size() > 100);
  CHECK(force(frames.back()) == Approx(kPressForce).epsilon(1e-9));
}

TEST_CASE("chain: a contact that hangs leaves no stale wall, and its return is a ramp") {
  if (!test::programs_are_built()) return;
  Press press;
  auto& [folder, hapticd, watcher, frames] = press;

  const pid_t contact = test::writer_of(watcher.contact);
  kill(contact, SIGSTOP);
  const bool faded =
      collect_until(watcher, frames, [](const ServoFrame& f) { return has(f, kServoStale); });
  kill(contact, SIGCONT);
  REQUIRE(faded);
  CHECK(force(frames.back()) == 0);
  REQUIRE(collect_until(watcher, frames, is_pressing));

  check_every_tick(watcher, frames);
  check_press(frames);
  const ServoFrame& stale = first(frames, kServoStale);
  CHECK(first(frames, kServoFading).tick < stale.tick);
  CHECK(stale.tick < first(frames, kServoReopening).tick);
}

TEST_CASE("chain: SIGTERM in mid-press ends with a zero wrench") {
  if (!test::programs_are_built()) return;
  Press press;
  auto& [folder, hapticd, watcher, frames] = press;
  hapticd.send(SIGTERM);
  CHECK(hapticd.exit_code() == 0);
  collect(watcher, frames);
  REQUIRE(frames.size() > 1);
  CHECK(has(frames.back(), kServoStopped));
  CHECK(frames.back().F_device_B == Wrench{});
  CHECK(force(frames[frames.size() - 2]) > 0);
  check_every_tick(watcher, frames);
  CHECK(watcher.servo.header()->state == static_cast<uint32_t>(SegmentState::kDead));
}

TEST_CASE("chain: the 2 kHz recording of a human hand loses no sample in real time") {
  if (!test::programs_are_built()) return;
  const auto recording = test::find_data("tue-1dof-bilateral/m2_question1c_rigid.csv");
  if (!recording) return;
  const TemporaryRuntimeFolder folder;
  const std::string config = test::from_source("configs/lever.toml");
  HapticdProcess hapticd({config, "--session", "lever", "--replay", *recording}, folder.path());
  Watcher watcher("lever");
  Frames frames;
  REQUIRE(collect_until(watcher, frames, has_ended));
  check_every_tick(watcher, frames);

  SessionConfig lever = load_config(config);
  use_trace(lever, *recording);
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
