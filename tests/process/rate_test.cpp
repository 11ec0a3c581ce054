// SPDX-License-Identifier: GPL-3.0-or-later
// The servo at each rate it can be configured to, and what an overrun does to it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <fstream>
#include <string>
#include <vector>

#include "tests/process/hapt_command.h"
#include "tests/process/hapticd_process.h"
#include "tests/process/watcher.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::eventually;
using test::HapticdProcess;
using test::TemporaryRuntimeFolder;
using test::Watcher;

constexpr int64_t kMs = 1'000'000;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  // the step is ten times slower
#else
constexpr bool kSanitized = false;
#endif

std::string write_session(const std::string& folder, int rate_khz, const std::string& wake) {
  const std::string path = folder + "/rate.toml";
  std::ofstream(path) << "[session]\nname = \"rate\"\n[servo]\nrate = \"" << rate_khz
                      << " kHz\"\nwake = \"" << wake
                      << "\"\n[device]\nkind = \"simulated-hand\"\n[[object]]\nname = \"block\"\n"
                         "primitive = \"box\"\nextent = [\"8 cm\", \"8 cm\", \"8 cm\"]\n";
  return path;
}

using Frames = std::vector<ServoFrame>;

/// Frames of at least this stretch of the servo's own time, none lost.
Frames collect_for(Watcher& watcher, int64_t duration_ns) {
  Frames frames;
  const bool seen = eventually([&] {
    for (ServoFrame frame; watcher.servo.next(frame);) frames.push_back(frame);
    return !frames.empty() && frames.back().t_ns - frames.front().t_ns >= duration_ns;
  });
  REQUIRE(seen);
  REQUIRE(watcher.servo.lost() == 0);
  REQUIRE(watcher.servo.generation() == 1);
  return frames;
}

/// Each frame lies on the grid, each grid point is a frame or a counted skip, and no tick was due
/// before the one before it was done: that would be a burst.
void check_grid(const Frames& frames, int64_t period) {
  for (size_t k = 1; k < frames.size(); ++k) {
    const ServoFrame& f = frames[k];
    const ServoFrame& before = frames[k - 1];
    const uint64_t skipped = f.skipped - before.skipped;
    CAPTURE(k, f.tick, skipped, before.wake_late_ns, before.busy_ns);
    REQUIRE(f.tick == before.tick + 1 + skipped);
    REQUIRE(f.t_ns == before.t_ns + static_cast<int64_t>(f.tick - before.tick) * period);
    REQUIRE(f.wake_late_ns >= 0);
    REQUIRE(f.t_ns >= before.t_ns + before.wake_late_ns + before.busy_ns - period);
    if (skipped > 0) REQUIRE(f.t_ns >= before.t_ns + before.wake_late_ns + before.busy_ns);
  }
}

}  // namespace

TEST_CASE("rate: the servo really runs at 1, 2, 4 and 8 kHz, sleeping or spinning") {
  if (!test::programs_are_built()) return;
  const int rate_khz = GENERATE(1, 2, 4, 8);
  const std::string wake = GENERATE("sleep", "hybrid");
  // spinning is the same code at every rate; at 8 kHz it leaves a busy machine of two cores so
  // little that the watcher starves
  if (wake == "hybrid" && rate_khz > 1) return;
  if (kSanitized && (rate_khz > 2 || wake == "hybrid")) {
    WARN("SKIPPED: too slow under sanitizers for " << rate_khz << " kHz, " << wake);
    return;
  }
  CAPTURE(rate_khz, wake);
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({write_session(folder.path(), rate_khz, wake)}, folder.path());
  Watcher watcher("rate");
  INFO(hapticd.log());
  REQUIRE(watcher.wait_for_all());
  const int64_t period = period_ns(1000.0 * rate_khz);
  const int64_t start_ns = now_ns();
  const Frames frames = collect_for(watcher, 1000 * kMs);
  check_grid(frames, period);

  const ServoFrame& first = frames.front();
  const ServoFrame& last = frames.back();
  const uint64_t grid_points = last.tick - first.tick;
  const uint64_t skipped = last.skipped - first.skipped;
  CHECK(frames.size() - 1 + skipped == grid_points);
  // on the wall's clock too, and not only on paper
  const double seconds = 1e-9 * static_cast<double>(last.t_ns - first.t_ns);
  CHECK(static_cast<double>(grid_points) / seconds == Approx(1000.0 * rate_khz).epsilon(1e-6));
  CHECK(1e-9 * static_cast<double>(now_ns() - start_ns) < 60);
  // the machine may take some away, never most
  CHECK(static_cast<double>(skipped) < 0.5 * static_cast<double>(grid_points));
}

TEST_CASE("rate: at 8 kHz a stop of 40 ms is one late tick and counted skips, never a burst") {
  if (kSanitized) {
    WARN("SKIPPED: too slow under sanitizers for 8 kHz");
    return;
  }
  if (!test::programs_are_built()) return;
  const TemporaryRuntimeFolder folder;
  HapticdProcess hapticd({write_session(folder.path(), 8, "sleep")}, folder.path());
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

  // 320 grid points went by: one is the late tick, the others are skipped
  const uint64_t skipped = frames.back().skipped - frames.front().skipped;
  CHECK(skipped >= 300);
  const uint64_t late = static_cast<uint64_t>(std::count_if(
      frames.begin(), frames.end(), [](const ServoFrame& f) { return f.wake_late_ns > 30 * kMs; }));
  CHECK(late >= 1);  // the machine may add one of its own
}

TEST_CASE("rate: hapt bench jitter without cyclictest says so in one line, and the rest is there") {
  const test::TemporaryFolder folder;
  const test::Ran ran = test::shell("PATH='" + test::program_folder().string() +
                                        "' hapt bench jitter --pairs 1 --seconds 0.2 "
                                        "--json",
                                    folder.path());
  CAPTURE(ran.output);
  CHECK((ran.code == 0 || ran.code == 1));
  CHECK(test::has(ran.output, "hapt: cyclictest gives no figures; install it with `./run bench`"));
  CHECK(test::has(ran.output, "\"peer\": \"cyclictest\", \"peer_value\": null"));
  CHECK(!test::has(ran.output, "cyclictest's"));
  CHECK(test::figure(ran.output, "wakes") > 0);
}

TEST_CASE("rate: hapt selftest prints every kind of violation and succeeds where there is none") {
  const test::TemporaryFolder folder;
  const test::Ran ran = test::hapt("selftest --ticks 5000 --json", folder.path());
  CAPTURE(ran.output);
  if (test::has(ran.output, "rt_guard has no hooks")) {
    WARN("SKIPPED: sanitizers interpose the same functions");
    return;
  }
  for (const char* kind : {"allocation", "free", "mutex", "condition", "rwlock", "system call"}) {
    CHECK(test::figure(ran.output, std::string("violations: ") + kind) == 0);
  }
  if (test::has(ran.output, "memory locked")) CHECK(ran.code == 0);
}

}  // namespace haptic
