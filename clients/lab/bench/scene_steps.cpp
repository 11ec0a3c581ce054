// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/scene_steps.h"

#include <algorithm>
#include <array>
#include <span>

#include "clients/lab/bench/workloads/turns.h"
#include "clients/lab/support/offline_session.h"
#include "clients/lab/support/thread_cpu.h"
#include "proto/os/realtime.h"
#include "proto/os/session_file.h"

namespace haptic {
namespace {

constexpr int64_t kPlayedNs = 10 * kNsPerSecond;  // [ns], of a scene
constexpr int64_t kStalledNs = 1'500'000'000;     // after the begin
constexpr int64_t kStallNs = 8'000'000;           // [ns], for which a sim has no processor
constexpr int64_t kQuietNs = 5 * kNsPerSecond;    // what is at rest is asleep after two seconds

/// A sim that sees what that of the session sees, with its pace: behind a step it rests two thirds
/// of its time (sim/main), and leaves out the ticks that fall into it.
class PacedSim {
 public:
  /// From `stalled_ns` on it has no processor for kStallNs.
  PacedSim(const SimModel& model, int64_t begin_ns, int64_t stalled_ns)
      : model_(model), stalled_ns_(stalled_ns) {
    sim_step(model_, state_, begin_ns);
  }

  void tick(const ServoFrame* hand, int64_t t_ns) {
    const bool is_stalled = t_ns >= stalled_ns_ && t_ns < stalled_ns_ + kStallNs;
    if (is_stalled || t_ns < next_ns_) {
      left_out_ += is_stalled ? 0 : 1;
      return;
    }
    const int64_t ns = cpu_ns_of([&] { scene_ = sim_step(model_, state_, {hand}, t_ns); });
    times_[moves() ? 1 : 0].push_back(1e-9 * static_cast<double>(ns));
    next_ns_ = t_ns + ns * 5 / 3;
  }

  const std::vector<double>& times(bool are_moving) const { return times_[are_moving ? 1 : 0]; }
  double left_out() const { return left_out_; }

 private:
  bool moves() const {
    return std::ranges::any_of(scene_.objects, [](const SceneObject& object) {
      return object.response != kNoResponse && object.V_WO != Twist{};
    });
  }

  const SimModel& model_;
  SimState state_{model_};
  SceneFrame scene_{};
  int64_t stalled_ns_, next_ns_ = 0;
  double left_out_ = 0;
  std::array<std::vector<double>, 2> times_;  // at rest, and where a body moves
};

}  // namespace

void add_scene_steps(const std::string& file, const Rows& all) {
  const SessionConfig config = load_config(find_session_file(file));
  PlayedSession played(config);
  Lockstep& session = played.lockstep;
  const SimModel model = build_sim(config, played.shapes.objects, played.shapes.collision_pieces);
  const int64_t begin_ns = session.scene().t_ns;
  PacedSim alone(model, begin_ns, begin_ns + kPlayedNs),
      stalled(model, begin_ns, begin_ns + kStalledNs);
  ServoFrame before{};
  for (int64_t t_ns = begin_ns; t_ns < begin_ns + kPlayedNs && session.step();) {
    const bool is_new = session.scene().t_ns != t_ns;
    t_ns = session.scene().t_ns;
    for (PacedSim* sim : {&alone, &stalled}) {
      if (is_new) sim->tick(&before, t_ns);
    }
    before = session.frame();
  }
  PacedSim quiet(model, begin_ns, begin_ns + kQuietNs);
  for (int64_t t_ns = begin_ns; t_ns < begin_ns + kQuietNs;) {
    quiet.tick(nullptr, t_ns += period_ns(config.sim_rate));
  }
  Rows rows = all.of(file + ", the first 10 s of its hand in lockstep");
  const auto add = [&](const char* when, const std::vector<double>& times) {
    if (times.empty()) return;
    add_times(rows, std::string("sim step CPU, ") + when + ":", times);
  };
  add("bodies move", alone.times(true));
  add("all at rest", quiet.times(false));
  rows.add({{"ticks left out", alone.left_out()},
            {"the same, more behind a stall of 8 ms", stalled.left_out() - alone.left_out()}});
}

}  // namespace haptic
