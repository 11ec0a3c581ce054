// SPDX-License-Identifier: GPL-3.0-or-later
// The servo at every rate that can be configured, and the effect of an overrun.
#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <fstream>
#include <string>
#include <vector>

#include "proto/math/units.h"
#include "proto/os/programs.h"
#include "tests/process/hapt_command.h"
#include "tests/process/hapticd_process.h"
#include "tests/process/watcher.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/torture_scale.h"

namespace haptic {
namespace {

using test::eventually;
using test::HapticdProcess;
using test::TemporaryRuntimeFolder;
using test::Watcher;

constexpr bool kSanitized = test::kSlowdown > 1;

std::string write_rate_session(const std::string& folder, int rate_khz, const std::string& wake) {
  const std::string path = folder + "/rate.toml";
  std::ofstream(path) << "[session]\nname = \"rate\"\n[servo]\nrate = \"" << rate_khz
                      << " kHz\"\nwake = \"" << wake
                      << "\"\n[device]\nkind = \"simulated-hand\"\n[[object]]\nname = \"block\"\n"
                         "primitive = \"box\"\nextent = [\"8 cm\", \"8 cm\", \"8 cm\"]\n";
  return path;
}

/// A frame, and when this process found it by its own clock.
struct SeenFrame : ServoFrame {
  int64_t seen_ns = 0;
};
using Frames = std::vector<SeenFrame>;

/// Frames over at least this duration of the servo's time, none lost. Begins again where the test
/// itself was kept from reading and the ring came around: that says nothing about the servo.
Frames collect_for(Watcher& watcher, int64_t duration_ns) {
  Frames frames;
  uint64_t lost = watcher.servo.lost();
  const bool seen = eventually([&] {
    for (ServoFrame frame; watcher.servo.next(frame);) frames.push_back({frame, now_ns()});
    if (watcher.servo.lost() != lost) {
      lost = watcher.servo.lost();
      frames.clear();
    }
    return !frames.empty() && frames.back().t_ns - frames.front().t_ns >= duration_ns;
  });
  REQUIRE(seen);
  REQUIRE(watcher.servo.generation() == 1);
  return frames;
}

/// Checks that each frame is on the grid, each grid point is a frame or a counted skip, and no tick
/// was due before the previous one was done: that would be a burst.
void check_grid(const Frames& frames, int64_t period) {
  for (size_t k = 1; k < frames.size(); ++k) {
    const SeenFrame& f = frames[k];
    const SeenFrame& before = frames[k - 1];
    const uint64_t skipped = f.skipped - before.skipped;
    CAPTURE(k, f.tick, skipped, before.wake_late_ns, before.busy_ns);
    REQUIRE(f.tick == before.tick + 1 + skipped);
    REQUIRE(f.t_ns == before.t_ns + static_cast<int64_t>(f.tick - before.tick) * period);
    REQUIRE(f.wake_late_ns >= 0);
    REQUIRE(f.t_ns >= before.t_ns + before.wake_late_ns + before.busy_ns);
    // nor was it found before it can have been computed
    REQUIRE(f.seen_ns >= f.t_ns + f.wake_late_ns + f.busy_ns);
  }
}

/// Ticks per second by this process's clock, between the frames of the first and last quarter that
/// were found soonest after their deadlines.
double rate_on_the_wall(const Frames& frames) {
  const auto delay = [](const SeenFrame& a, const SeenFrame& b) {
    return a.seen_ns - a.t_ns < b.seen_ns - b.t_ns;
  };
  const auto quarter = static_cast<ptrdiff_t>(frames.size() / 4);
  const SeenFrame& first = *std::min_element(frames.begin(), frames.begin() + quarter, delay);
  const SeenFrame& last = *std::min_element(frames.end() - quarter, frames.end(), delay);
  const double seconds = 1e-9 * static_cast<double>(last.seen_ns - first.seen_ns);
  return static_cast<double>(last.tick - first.tick) / seconds;
}

/// Why the share of late ticks has no goal here; empty if it has.
std::string no_realtime(const Watcher& watcher) {
  const RealtimeReport rights = realtime_of(*watcher.servo.header());
  return (rights.bits & kRealtimeFifo) != 0 ? "" : rights.explain();
}

}  // namespace

TEST_CASE("rate: the servo really runs at 1, 2, 4 and 8 kHz, sleeping or spinning") {
  const int rate_khz = GENERATE(1, 2, 4, 8);
  const std::string wake = GENERATE("sleep", "hybrid");
  // spinning does not depend on the rate: those between the slowest and the fastest with a larger
  // HAPTIC_TORTURE_SCALE. At 8 kHz it would starve the watcher on a busy machine of two cores
  const int fastest_khz = test::torture_scale() > 1 ? 4 : 1;
  if (wake == "hybrid" && rate_khz > fastest_khz) return;
  if (kSanitized && (rate_khz > 2 || wake == "hybrid")) {
    WARN("SKIPPED: too slow under sanitizers for " << rate_khz << " kHz, " << wake);
    return;
  }
  CAPTURE(rate_khz, wake);
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({write_rate_session(folder.path(), rate_khz, wake)}, folder.path());
  Watcher watcher("rate");
  INFO(hapticd.log());
  REQUIRE(watcher.wait_for_all());
  const int64_t period = period_ns(1000.0 * rate_khz);
  // frames that were already in the ring say nothing about the wall clock
  collect_for(watcher, 1 * kMs);
  const Frames frames = collect_for(watcher, 500 * kMs);
  check_grid(frames, period);

  const ServoFrame& first = frames.front();
  const ServoFrame& last = frames.back();
  const uint64_t grid_points = last.tick - first.tick;
  const uint64_t skipped = last.skipped - first.skipped;
  CHECK(frames.size() - 1 + skipped == grid_points);
  REQUIRE(frames.size() >= 100);
  // by the wall clock too, not only by the time stamps
  CHECK(rate_on_the_wall(frames) == Approx(1000.0 * rate_khz).epsilon(0.02));
  // without real-time rights other programs may take any share of the ticks
  if (const std::string why = no_realtime(watcher); !why.empty()) {
    WARN("SKIPPED: the share of skipped ticks: " << why);
    return;
  }
  // the machine may take some, never most
  CHECK(static_cast<double>(skipped) < 0.5 * static_cast<double>(grid_points));
}

TEST_CASE("rate: at 8 kHz a stop of 40 ms is one late tick and counted skips, never a burst") {
  if (kSanitized) {
    WARN("SKIPPED: too slow under sanitizers for 8 kHz");
    return;
  }
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({write_rate_session(folder.path(), 8, "sleep")}, folder.path());
  Watcher watcher("rate");
  INFO(hapticd.log());
  REQUIRE(watcher.wait_for_all());
  const int64_t period = period_ns(8000);
  Frames frames = collect_for(watcher, 50 * kMs);
  const pid_t servo = test::writer_of(watcher.servo);
  kill(servo, SIGSTOP);
  sleep_until(now_ns() + 40 * kMs);
  kill(servo, SIGCONT);
  const Frames after = collect_for(watcher, 100 * kMs);
  frames.insert(frames.end(), after.begin(), after.end());
  check_grid(frames, period);

  // 320 grid points have passed: one is the late tick, the others are skipped
  const uint64_t skipped = frames.back().skipped - frames.front().skipped;
  CHECK(skipped >= 300);
  const uint64_t late = static_cast<uint64_t>(std::count_if(
      frames.begin(), frames.end(), [](const ServoFrame& f) { return f.wake_late_ns > 30 * kMs; }));
  CHECK(late >= 1);  // the machine may add one
}

TEST_CASE("rate: hapt bench jitter without cyclictest says so in one line, and the rest is there") {
  const test::TemporaryFolder folder;
  const test::Ran ran = test::shell("PATH='" + test::program_folder().string() +
                                        "' hapt bench jitter --pairs 1 --for 1 "
                                        "--json",
                                    folder.path());
  CAPTURE(ran.output);
  CHECK((ran.code == 0 || ran.code == 1));
  CHECK(test::has(ran.output, "hapt: cyclictest gives no figures; install it with `./run bench`"));
  CHECK(test::has(ran.output, "\"peer\": \"cyclictest\", \"peer_value\": null"));
  CHECK(!test::has(ran.output, "cyclictest's"));
  CHECK(test::figure(ran.output, "wakes") > 0);
}

}  // namespace haptic
