// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <numeric>
#include <random>
#include <vector>

#include "proto/config/config.h"
#include "proto/math/units.h"
#include "proto/wire/scene_pose.h"
#include "sim/step.h"

/// A hand presses along z on an object that a client integrates at its own rate, a frame late, and
/// sim moves by what the client says. The judge integrates hand, coupling and body as one, in steps
/// of 20 µs, and shares neither code nor formula with sim.
namespace haptic::test {

constexpr double kFine = 2e-5;  // of every exact integration [s]
constexpr double kHandMass = 0.65, kHandSpring = 300, kHandDamping = 2;
constexpr double kStiffness = 3000, kDamper = 2;  // of the coupling
constexpr int64_t kStartNs = 1'000'000'000;

/// The world of a client's object, in which it may lie otherwise than the client says.
struct GivenWorld {
  double mass = 0.1, stiffness = 500, damping = 0.05;
  double wall = 1, wall_stiffness = 0;  // one behind the object that the client does not state
  double dry = 0;                       // friction [N]
  double second = 0;                    // mass of a body 2 mm behind it that is not stated [kg]
};

struct GivenBody {
  double x = 0, v = 0, x2 = 2e-3, v2 = 0;

  double behind(const GivenWorld& world) const {
    const double at = world.second > 0 ? x2 : world.wall;
    const double k = world.second > 0 ? 5000 : world.wall_stiffness;
    return k * std::max(0.0, x - at);
  }
  double own(const GivenWorld& world) const {
    return -world.stiffness * x - world.damping * v - world.dry * std::tanh(v / 1e-3) -
           behind(world);
  }
  void step(const GivenWorld& world, double h, double push) {
    x += 0.5 * h * v;
    x2 += 0.5 * h * v2;
    const double hit = world.second > 0 ? behind(world) : 0;
    v += h * (own(world) + push) / world.mass;
    if (world.second > 0) v2 += h * hit / world.second;
    x += 0.5 * h * v;
    x2 += 0.5 * h * v2;
  }
};

struct GivenHand {
  double x = 0, v = 0;

  void step(double force, double intent) {
    x += 0.5 * kFine * v;
    v += kFine * (kHandSpring * (intent - x) - kHandDamping * v - force) / kHandMass;
    x += 0.5 * kFine * v;
  }
  double energy() const {
    return 0.5 * (kHandMass * v * v + kHandSpring * (x + 2e-3) * (x + 2e-3));
  }
};

inline double coupling_force(const GivenHand& hand, double x, double v) {
  const double pen = hand.x - x;
  return pen > 0 ? std::max(0.0, kStiffness * pen + kDamper * (hand.v - v)) : 0;
}

enum class Motion { kPush, kHold, kTaps, kTap };

inline double intent_at(Motion motion, double t) {
  if (motion == Motion::kHold) return 20e-3;
  if (motion == Motion::kPush) return -1e-3 + 4e-3 * std::min(t, 7.0);
  return motion == Motion::kTaps && t < 18 ? -2e-3 + 14e-3 * std::sin(21.5 * t) : -2e-3;
}

inline GivenHand hand_at_start(Motion motion) {
  if (motion == Motion::kTap) return {-2e-3, 0.3};
  return {motion == Motion::kHold ? 0 : -2e-3, 0};
}

/// Hand, coupling and body as one: the force at each tick.
struct JudgedRun {
  std::vector<double> forces;
  double back = 0;  // energy of the hand when a tap is over, over that before
};
inline JudgedRun judge(const GivenWorld& world, Motion motion, double seconds) {
  JudgedRun run;
  GivenHand hand = hand_at_start(motion);
  GivenBody body;
  const double begin = hand.energy();
  for (int n = 0; n < seconds / kTick; ++n) {
    if (motion == Motion::kTap && hand.x < -2e-3 && hand.v < 0) break;
    for (int i = 0; i < 50; ++i) {
      const double force = coupling_force(hand, body.x, body.v);
      if (i == 0) run.forces.push_back(force);
      hand.step(force, intent_at(motion, n * kTick + i * kFine));
      body.step(world, kFine, force);
    }
  }
  run.back = hand.energy() / begin;
  return run;
}

/// What a client says and how it sends it.
struct GivenClientRun {
  double rate = 100;                         // [Hz]
  double jitter = 0;                         // of its frames, in periods
  double mass_said = 1, stiffness_said = 1;  // factors
  double seconds = 20;
  double max_force = HUGE_VAL;  // of the object on a hand [N]
  bool uses_integral = true;    // S beside J
  bool has_model = true;        // else the object is placed by its frames alone
};

/// The client: integrates with what was pushed, as a force linear in time with the same J and S.
class GivenClientBody {
 public:
  /// It moves along an axis of W, about a place.
  GivenClientBody(const GivenWorld& world, const GivenClientRun& run, int axis = 2,
                  const Vec3& place_W = {})
      : world_(world), run_(run), axis_(axis), place_W_(place_W) {}

  /// Makes the frame of an instant from the counters of this servo frame.
  GivenFrame frame(const ServoFrame& servo, int64_t t_ns) {
    const double span = seconds_of(t_ns - used_ns_);
    const ObjectPush push = servo.pushes.empty() ? ObjectPush{} : servo.pushes[0];
    const double J = push.impulse_W.f[axis_];
    const double S = push.impulse_time_W.f[axis_] + J * seconds_of(t_ns - servo.t_ns);
    if (used_ns_ != 0 && span > 0) {
      const double dJ = J - J_, lack = S - S_ - J_ * span - 0.5 * dJ * span;
      const double slope = run_.uses_integral ? -12 * lack / (span * span * span) : 0;
      const int n = static_cast<int>(std::ceil(span / kFine));
      for (int i = 0; i < n; ++i) {
        body.step(world_, span / n, dJ / span - 0.5 * slope * span + slope * (i + 0.5) * span / n);
      }
    }
    used_ns_ = t_ns;
    J_ = J;
    S_ = S;
    return said(servo.tick, t_ns);
  }

  GivenBody body;

 private:
  GivenFrame said(uint64_t tick, int64_t t_ns) {
    GivenFrame frame{};
    frame.seq = ++seq_;
    frame.t_ns = t_ns;
    GivenMotion motion{};
    motion.ticks[0] = tick;
    motion.t_ns = t_ns;
    motion.X_WO.p = place_W_;
    motion.X_WO.p[axis_] += body.x;
    motion.V_WO.v[axis_] = body.v;
    motion.acceleration_W.v[axis_] = body.own(world_) / world_.mass;
    for (size_t i = 0; i < 3; ++i) {
      motion.mobility[7 * i] = 1 / (world_.mass * run_.mass_said);
      motion.stiffness[7 * i] = world_.stiffness * run_.stiffness_said;
      motion.damping[7 * i] = world_.damping;
    }
    frame.moves.push_back(motion);
    return frame;
  }

  GivenWorld world_;
  GivenClientRun run_;
  int axis_;
  Vec3 place_W_;
  int64_t used_ns_ = 0;
  double J_ = 0, S_ = 0;
  uint64_t seq_ = 0;
};

/// A session of one object that a client may move.
inline SessionConfig given_session() {
  SessionConfig config;
  config.n_objects = 1;
  config.n_clients = 1;
  config.clients[0].n_moves = 1;
  config.clients[0].max_force = 50;
  config.clients[0].max_power = 20;
  config.sim_rate = 1000;
  return config;
}

struct GivenResult {
  double cycle = 0;   // standard deviation of the force in the last second [N]
  double rms = 0;     // of the force's error [N]
  double gained = 0;  // work on the hand in all [J]
  double back = 0;    // as JudgedRun::back
  double step = 0;    // largest change of the force between ticks of a fresh frame [N]
  double least_share = 1;
  bool is_said = false;  // that it answers otherwise than its client says
  bool ran_away = false;
};

/// The object as a free body where its client's frame has it, with what was pushed since.
inline void place_by(const GivenMotion& said, const ServoFrame& used, SceneFrame& scene) {
  SceneObject& object = scene.objects[0];
  object.X_WO = said.X_WO;
  object.V_WO = said.V_WO;
  object.t_ns = said.t_ns;
  object.extrapolation_ns = kMostExtrapolationNs;
  scene.responses[0] = {said.acceleration_W, said.mobility};
  const auto& [J, S] = used.pushes[0];
  scene.seen[0] = {J, S, {}, used.t_ns};
}

/// Cycle and error of a run.
inline void measure(const std::vector<double>& forces, const std::vector<double>& truth,
                    GivenResult& out) {
  const size_t last = std::min<size_t>(forces.size(), 1000),
               both = std::min(forces.size(), truth.size());
  double sum = 0, squares = 0, errors = 0;
  for (size_t i = forces.size() - last; i < forces.size(); ++i) {
    sum += forces[i];
    squares += forces[i] * forces[i];
  }
  for (size_t i = 0; i < both; ++i) errors += std::pow(forces[i] - truth[i], 2);
  const double mean = sum / static_cast<double>(last);
  out.cycle = std::sqrt(std::max(0.0, squares / static_cast<double>(last) - mean * mean));
  out.rms = std::sqrt(errors / static_cast<double>(both));
}

/// The whole loop: servo's spring and counters, sim, the client.
inline GivenResult run_given(const GivenWorld& world, const GivenClientRun& run, Motion motion,
                             const JudgedRun& truth) {
  SessionConfig config = given_session();
  config.clients[0].max_force = std::min(run.max_force, config.clients[0].max_force);
  const SimModel model = build_sim(config);
  SimState state(model);
  GivenClientBody client(world, run);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  struct Waiting {
    int64_t arrives_ns;
    GivenFrame frame;
    ServoFrame at;  // whose counters it has used
  };
  GivenFrame shown{};
  ServoFrame at_frame{};
  std::deque<Waiting> waiting;
  GivenHand hand = hand_at_start(motion);
  hand.x = -0.1;  // away, until the client is heard
  ServoFrame servo{};
  servo.impulses_since_ns = kStartNs;
  servo.pushes.resize(1);
  SceneFrame scene = sim_step(model, state, kStartNs);
  GivenResult out;
  std::vector<double> forces;
  double begin = 0, before = 0;
  // let go, five fresh frames, let in
  const int n_lead = 300 + static_cast<int>(12 / (kTick * run.rate)),
            end = n_lead + static_cast<int>(run.seconds / kTick);
  int64_t next_ns = kStartNs + static_cast<int64_t>(1e9 / run.rate);
  int n_frames = 1;
  bool over = false;
  for (int n = 1; n < end; ++n) {
    const int64_t t_ns = kStartNs + n * kMs;
    for (; next_ns <= t_ns; ++n_frames) {
      for (Waiting& w : waiting) w.arrives_ns = std::min(w.arrives_ns, next_ns);
      waiting.push_back({INT64_MAX, client.frame(servo, next_ns), servo});
      const double later = (n_frames + 1 + run.jitter * uniform(random)) / run.rate;
      next_ns = std::max(next_ns, kStartNs + static_cast<int64_t>(1e9 * later));
    }
    const bool fresh = !waiting.empty() && waiting.front().arrives_ns <= t_ns;
    if (fresh) {
      set_giving(model.given, state.given, 0, 1);
      see_client(model.given, state.given, 0, 1, waiting.front().frame, t_ns);
      shown = waiting.front().frame;
      at_frame = waiting.front().at;
      waiting.pop_front();
    }
    if (n > 1) see_hand(model.given, state.given, 0, servo);
    scene = sim_step(model, state, {&servo}, t_ns);
    if (!run.has_model && !shown.moves.empty()) place_by(shown.moves[0], at_frame, scene);
    if (n == n_lead) {
      hand = hand_at_start(motion);
      begin = hand.energy();
    }
    servo.tick = static_cast<uint64_t>(n);
    ObjectPush& pushed = servo.pushes[0];
    pushed.impulse_time_W = pushed.impulse_time_W + kTick * pushed.impulse_W;
    servo.t_ns = t_ns;
    const Pose X_WO = object_pose_at(scene, 0, t_ns, push_of(servo, kFirstHand));
    const Twist V_WO = object_twist_at(scene, 0, t_ns, push_of(servo, kFirstHand));
    const double share = 1 - scene.objects[0].reduction;
    if (n >= n_lead) out.is_said |= (scene.givers[0].flags & kGiverSoftened) != 0;
    if (n >= n_lead) out.least_share = std::min(out.least_share, share);
    // the client's object pushes no harder than the session file lets it
    const double force =
        over ? 0 : std::min(share * coupling_force(hand, X_WO.p.z, V_WO.v.z), run.max_force);
    if (!std::isfinite(force) || force > 1000) {
      out.ran_away = true;
      out.cycle = out.rms = out.gained = 999;
      return out;
    }
    pushed.impulse_W.f.z += kTick * force;
    servo.X_WT.p.z = hand.x;
    servo.depth = std::max(0.0, hand.x - X_WO.p.z);
    servo.translational_stiffness = kStiffness;
    servo.V_WT.v.z = hand.v;
    if (n < n_lead) continue;
    if (fresh) out.step = std::max(out.step, std::fabs(force - before));
    before = force;
    forces.push_back(force);
    const double from = hand.x;
    for (int i = 0; i < 50 && !over; ++i) {
      hand.step(force, intent_at(motion, (n - n_lead) * kTick + i * kFine));
    }
    out.gained -= force * (hand.x - from);
    if (motion == Motion::kTap && !over && hand.x < -2e-3 && hand.v < 0) over = true;
    if (motion == Motion::kTap && over) break;
  }
  out.back = hand.energy() / begin / truth.back;
  measure(forces, truth.forces, out);
  return out;
}

}  // namespace haptic::test
