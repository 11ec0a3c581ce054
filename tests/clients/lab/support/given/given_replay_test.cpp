// SPDX-License-Identifier: GPL-3.0-or-later
// What a client gave in a recording is given again without it, on another clock and with other
// ticks: the object moves as it moved. The judge is what was seen while it was recorded.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "clients/lab/support/offline_session.h"
#include "clients/log/trace_writer.h"
#include "device-io/replay/replay.h"
#include "proto/config/devices.h"
#include "tests/clients/lab/support/pushed_body.h"
#include "tests/sim/given/given_loop.h"
#include "tests/support/temporary_folder.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr int kTicks = 3000;
constexpr int kLeaves = 1600, kComes = 2100;  // ticks between which there is no client
// a clock that runs for 83 days more, and a servo that has run for a while
constexpr int64_t kLaterNs = 7'171'717'171'717'171;
constexpr uint64_t kMoreTicks = 987'654;

PushedSession replayed_box() {
  PushedSession session(0, 800);
  session.config.n_clients = 1;
  session.config.clients[0].n_moves = 1;
  session.config.clients[0].max_force = 50;
  session.config.clients[0].max_power = 20;
  return session;
}

HandModel hand_that_pushes() {
  HandModel hand;
  hand.x = -0.02;
  hand.intent = [](double t) { return t < 1 ? rise(-0.02, 0.05, 0.6)(t - 0.3) : 0.03 - 0.01 * t; };
  return hand;
}

/// The frames of a run, written as those of a session on the later clock.
class LaterRecording {
 public:
  LaterRecording(const std::string& path, const McapMetadata& metadata) : trace_(path, metadata) {
    trace_.add_topic(info_of(given_topic(0)));
  }
  void control(int64_t t_ns, uint64_t generation) {
    ControlFrame frame{};
    frame.t_ns = t_ns + kLaterNs;
    frame.giving[0] = generation;
    trace_.write(kControlTopic, frame, {frame.t_ns, frame.t_ns, 0});
  }
  void given(GivenFrame frame, int64_t came_ns) {
    frame.t_ns += kLaterNs;
    for (GivenMotion& motion : frame.moves) {
      motion.t_ns += kLaterNs;
      motion.ticks[0] += kMoreTicks;
    }
    trace_.write(given_topic(0), frame, {came_ns + kLaterNs, came_ns + kLaterNs, 0});
  }
  void servo(ServoFrame frame) {
    frame.t_ns += kLaterNs;
    frame.device.t_ns += kLaterNs;
    frame.tick += kMoreTicks;
    trace_.write(servo_topic(kFirstHand), frame, {frame.t_ns, frame.t_ns, 0});
  }
  void close() { REQUIRE(trace_.close()); }

 private:
  TraceWriter trace_;
};

/// Where the object is in W, and how much of it is let in, tick by tick.
struct Seen {
  std::vector<double> x, share;
  void add(const Lockstep& session) {
    const SceneObject& object = session.scene().objects[0];
    x.push_back(object.X_WO.p.x);
    share.push_back(1 - object.reduction);
  }
};

/// A client integrates the box, leaves and comes again, while a hand pushes through it.
Seen record(const std::string& path, bool loses_frames = false) {
  Pushed pushed(replayed_box(), hand_that_pushes());
  Lockstep& session = pushed.lockstep;
  LaterRecording recording(path, {});
  Seen seen;
  const GivenWorld world{.mass = 0.1, .stiffness = 200, .damping = 0.5};
  std::optional<GivenClientBody> client;
  std::optional<GivenFrame> waiting;
  for (int n = 0; n < kTicks; ++n) {
    const int64_t t_ns = session.next_t_ns();
    if (n == 20 || n == kComes) {
      client.emplace(world, GivenClientRun{}, 0, Vec3{0.03, 0, 0});
      recording.control(t_ns, n == 20 ? 1 : 2);
    }
    if (n == kLeaves) {
      client.reset();
      session.leave(0);
      recording.control(t_ns, 0);
    }
    if (client && waiting) {
      session.give(0, *waiting);
      recording.given(*waiting, t_ns);
    }
    waiting.reset();
    // it comes a tick late
    if (client && n % 10 == 0) waiting = client->frame(session.frame(), session.frame().t_ns);
    REQUIRE(session.step());
    if (!loses_frames || n % 5 != 3) recording.servo(session.frame());
    seen.add(session);
  }
  recording.close();
  return seen;
}

struct Played {
  Seen seen;
  uint64_t refused = 0;
};

Played play_again(const std::string& path, double rate = 1000, int misses_every = 0,
                  bool gives = true) {
  PushedSession made = replayed_box();
  made.config.servo_rate = rate;
  use_trace(made.config, path);
  Replay hand(made.config.device);
  Lockstep session(made.config, made.shapes, hand);
  std::optional<GivenInLockstep> given;
  if (gives) given.emplace(made.config);
  Played played;
  for (int n = 1;; ++n) {
    if (misses_every > 0 && n % misses_every == 0) session.miss_tick();
    if (gives ? !given->step(session) : !session.step()) break;
    played.seen.add(session);
  }
  for (const GiverState& state : session.scene().givers) played.refused += state.refused;
  return played;
}

/// The largest distance of the object from where it was at the same instant [m].
double apart(const Seen& then, const Seen& now, int step) {
  double most = 0;
  for (size_t i = 0; i < now.x.size(); ++i) {
    const size_t at = i * static_cast<size_t>(step);
    if (at < then.x.size()) most = std::max(most, std::fabs(then.x[at] - now.x[i]));
  }
  return most;
}

}  // namespace

TEST_CASE("given replay: the object moves as it moved, on another clock and with other ticks") {
  const TemporaryFolder folder;
  const std::string path = folder.path() + "/given.mcap";
  const bool loses_frames = GENERATE(false, true);
  const Seen then = record(path, loses_frames);
  // the hand has pushed it away by millimetres, it was let go of and let in again
  const auto [least, most] = std::ranges::minmax(then.x);
  REQUIRE(most - least > 5e-3);
  REQUIRE(then.share[kLeaves - 1] == 1);
  REQUIRE(then.share[kComes - 1] == 0);
  REQUIRE(then.share.back() == 1);

  const Played now = play_again(path);
  CHECK(now.refused == 0);
  // every fifth sample of the hand is not recorded then, and is made of its neighbours
  const double lost = loses_frames ? 1e-6 : 0;
  // rounding alone: the hand is recorded at the same ticks, and all times are whole nanoseconds
  CHECK(apart(then, now.seen, 1) <= 1e-9 + lost);
  REQUIRE(now.seen.share.size() >= kTicks - 5);
  if (!loses_frames) {
    for (size_t n = 0; n < kTicks; ++n) CHECK(now.seen.share[n] == then.share[n]);
  }
  // nobody gives: it stands
  const Seen without = play_again(path, 1000, 0, false).seen;
  CHECK(apart(then, without, 1) > 5e-3);
}

TEST_CASE("given replay: neither another rate of the servo nor missed ticks break it") {
  const TemporaryFolder folder;
  const std::string path = folder.path() + "/given.mcap";
  const Seen then = record(path);
  // The spring is held for two ticks, and a frame may be of a tick half a period earlier: of 10 N
  // on 100 g this is 0.1 m/s² · 1 s² at most, and the client's frames lead the object back.
  constexpr double kMost = 2e-4;  // [m]
  const Played slow = play_again(path, 500);
  CHECK(slow.refused == 0);
  CHECK(apart(then, slow.seen, 2) <= kMost);
  PushedSession made = replayed_box();
  const Played missing = play_again(path, 1000, 7);
  CHECK(missing.refused == 0);
  Seen at_ticks;
  for (size_t n = 0, tick = 0; n < missing.seen.x.size() && tick < then.x.size(); ++n, ++tick) {
    if ((n + 1) % 7 == 0) ++tick;
    if (tick < then.x.size()) at_ticks.x.push_back(then.x[tick]);
  }
  CHECK(apart(at_ticks, missing.seen, 1) <= kMost);
}
