// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "clients/lab/bench/live_session.h"
#include "clients/lab/bench/peers/bodies.h"
#include "clients/lab/bench/scene_steps.h"
#include "clients/lab/bench/workloads/turns.h"
#include "clients/lab/support/measurement.h"
#include "clients/lab/support/median.h"
#include "clients/lab/support/thread_cpu.h"
#include "contact/shape/mesh/primitives.h"
#include "proto/config/command_line.h"
#include "proto/math/units.h"
#include "proto/os/progress.h"
#include "proto/os/session_file.h"
#include "sim/step.h"

namespace haptic {
namespace {

constexpr int64_t kTickNs = 1'000'000;    // [ns]
constexpr double kGoalStep = 0.5e-3;      // p99 of sim's step [s]: half of its period
constexpr double kGoalContacts = 100;     // in the wall, on average, at least
constexpr double kGoalBusy = 1.1;         // p99 of the servo with masses over that without
constexpr double kGoalRate = 0.9;         // of contact with masses over that without
constexpr Vec3 kBrick{0.02, 0.01, 0.01};  // [m]
constexpr double kBrickMass = 0.01;       // [kg]
constexpr double kFriction = 0.5;         // of every body
constexpr Vec3 kGravity{0, 0, -9.81};     // [m/s²]
constexpr int kWarmUp = 500;              // ticks until the wall has settled
constexpr int kChunk = 50;                // ticks of one contestant before the next has its turn
constexpr int kRows = 5, kColumns = 3;    // of bricks in a wall

struct Options {
  int ticks = 5000, rounds = 5;
  double seconds = 5;
  std::string config = "heap.toml";
};

/// A wall of fifteen bricks on the ground: object 0 is the ground, as the sixteenth.
std::vector<PeerBox> brick_wall() {
  std::vector<PeerBox> boxes{{{0.4, 0.4, 0.02}, {{0, 0, -0.01}, {}}, 0, kFriction}};
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const Vec3 p{kBrick.x * (column + 0.5 * (row % 2)), 0, kBrick.z * (row + 0.5)};
      boxes.push_back({kBrick, {p, {}}, kBrickMass, kFriction});
    }
  }
  return boxes;
}

/// The shapes of a wall and our sim of it, pushed by the counters of a hand.
struct PushedWall {
  SessionConfig config;
  std::deque<MeshShapeData> owned;
  std::vector<MeshShape> shapes;
  SimModel model;
  SimState state;
  ServoFrame hand{};

  explicit PushedWall(const std::vector<PeerBox>& boxes) {
    config.sim_rate = 1 / kTick;
    config.gravity_W = kGravity;
    for (const PeerBox& box : boxes) {
      const primitive::Box made{box.extent};
      owned.push_back(build_shape(make_box(made)));
      shapes.push_back(owned.back().view());
      ObjectConfig& object = config.objects[config.n_objects++];
      object.primitive = made;
      object.X_WO = box.X_WO;
      object.body.mass = box.mass;
      object.material.friction_dynamic = box.friction;
    }
    model = build_sim(config, shapes);
    hand.t_ns = hand.impulses_since_ns = kTickNs;
    sim_step(model, state, {&hand}, hand.t_ns);
  }

  void push(size_t box, const Vec3& impulse_W) {
    hand.t_ns += kTickNs;
    // each box is a body
    hand.pushes.resize(config.n_objects);
    auto& [J_W, S_W] = hand.pushes[box];
    S_W = S_W + kTick * J_W;
    J_W.f += impulse_W;
  }
  void step() { sim_step(model, state, {&hand}, hand.t_ns); }
  double n_contacts() const { return static_cast<double>(state.bodies.world->n_contacts()); }
};

/// A hand that presses to and fro on the brick in the middle of the top row, and moves nothing far.
Vec3 push_at(int tick) {
  constexpr double kForce = 0.05, kFrequency = 5;  // [N], [Hz]
  return {0, kForce * kTick * std::sin(2 * M_PI * kFrequency * kTick * tick), 0};
}

void add_steps(const Options& options, const Rows& all) {
  const std::vector<PeerBox> boxes = brick_wall();
  const size_t pushed = boxes.size() - 2;
  PushedWall ours(boxes);
  const std::vector<std::pair<std::string, int>> kinds{{"Bullet alone, 10 iterations", 10},
                                                       {"Bullet alone, 50 iterations", 50}};
  std::vector<std::unique_ptr<BodiesPeer>> peers;
  for (const auto& kind : kinds) peers.push_back(make_bullet_bodies(boxes, kGravity, kind.second));
  std::vector<double> times, contacts;
  std::vector<std::vector<double>> peer_times(peers.size());
  for (int begin = -kWarmUp; begin < options.ticks; begin += kChunk) {
    for (int tick = begin; tick < begin + kChunk; ++tick) {
      ours.push(pushed, push_at(tick));
      const double took = cpu_seconds_of([&] { ours.step(); });
      if (tick < 0) continue;
      times.push_back(took);
      contacts.push_back(ours.n_contacts());
    }
    for (size_t i = 0; i < peers.size() && peers[i]; ++i) {
      for (int tick = begin; tick < begin + kChunk; ++tick) {
        peers[i]->push(pushed, push_at(tick));
        const double took = cpu_seconds_of([&] { peers[i]->step(kTick); });
        if (tick >= 0) peer_times[i].push_back(took);
      }
    }
  }
  Rows rows = all.of("a wall of 15 bricks on the ground, one of them pushed");
  rows.add("contacts, median", percentile(contacts, 50), "", at_least(kGoalContacts));
  add_times(rows, "sim step CPU", times, kGoalStep);
  for (size_t i = 0; i < peers.size() && peers[i]; ++i) {
    add_beside(rows, "sim step CPU", times, kinds[i].first, peer_times[i]);
  }
}

/// A copy of the session file without the tables that give its objects mass, among links to the
/// files that lie beside it. Returns its path.
std::string without_masses(const std::string& path, const std::string& folder) {
  namespace fs = std::filesystem;
  const fs::path source = fs::absolute(path), fixed = fs::path(folder) / "fixed";
  fs::create_directory(fixed);
  for (const fs::directory_entry& entry : fs::directory_iterator(source.parent_path())) {
    if (entry.path() != source) fs::create_symlink(entry, fixed / entry.path().filename());
  }
  std::ifstream in(source);
  std::ofstream out(fixed / source.filename());
  bool is_skipped = false;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("[")) {
      is_skipped = line.starts_with("[object.body]") || line.starts_with("[[joint]]");
    }
    if (!is_skipped) out << line << '\n';
  }
  return fixed / source.filename();
}

void add_sessions(const Options& options, const Rows& all) {
  const RuntimeFolder folder;
  const std::string with = find_session_file(options.config);
  const std::array<std::string, 2> configs{without_masses(with, folder.path()), with};
  std::array<std::vector<SessionWindow>, 2> windows;
  std::vector<double> busy_ratio, rate_ratio;
  Progress progress("sessions", options.rounds);
  for (int round = 0; round < options.rounds; ++round) {
    for (size_t i = 0; i < 2; ++i) {
      LiveSession session(folder, "bench-world", configs[i]);
      windows[i].push_back(session.watch(options.seconds));
    }
    const SessionWindow &without = windows[0].back(), &with_masses = windows[1].back();
    busy_ratio.push_back(with_masses.busy_p99 / without.busy_p99);
    rate_ratio.push_back(with_masses.contact_rate / without.contact_rate);
    progress.step();
  }
  const auto of = [&](size_t i, double SessionWindow::*quantity) {
    return median_of(windows[i], quantity);
  };
  Rows rows = all.of(options.config + ", live, with masses and without");
  rows.add({{"servo busy p50, without", of(0, &SessionWindow::busy_p50), "s"},
            {"servo busy p50, with", of(1, &SessionWindow::busy_p50), "s"},
            {"servo busy p99, without", of(0, &SessionWindow::busy_p99), "s"},
            {"servo busy p99, with", of(1, &SessionWindow::busy_p99), "s"},
            {"servo busy p99, with over without", median(busy_ratio), "", at_most(kGoalBusy)},
            {"contact rate, without", of(0, &SessionWindow::contact_rate), "Hz"},
            {"contact rate, with", of(1, &SessionWindow::contact_rate), "Hz"},
            {"contact rate, with over without", median(rate_ratio), "", at_least(kGoalRate)},
            {"planes that push, mean, without", of(0, &SessionWindow::contacts)},
            {"planes that push, mean, with", of(1, &SessionWindow::contacts)}});
}

void all_rows(const Options& options, const Rows& all) {
  all.machine("world");
  add_steps(options, all);
  add_scene_steps(options.config, all);
  add_sessions(options, all);
}

}  // namespace

/// Objects with mass: CPU time of sim's step for a wall of fifteen bricks of which one is pushed,
/// in turns with Bullet's own stepping of the same wall; then live sessions with masses and
/// without, in turns: the servo's work and the rate of contact.
Measured bench_world(Command& command) {
  const auto options = std::make_shared<Options>();
  add_counts(command, {{"--ticks", &options->ticks, "of 1 ms, of the wall", 100, 10'000'000}});
  command.option("--config FILE", options->config, "session file whose objects have mass")
      .show_default();
  command.quantity("--for", options->seconds, Dimension::kTime, {0.2, 3600}, "of each session", "s")
      .show_default();
  add_counts(command, {rounds_of(options->rounds, "of sessions in turn; medians are reported")});
  return measured(all_rows, options);
}

}  // namespace haptic
