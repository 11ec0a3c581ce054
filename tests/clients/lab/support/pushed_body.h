// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <deque>
#include <functional>
#include <utility>
#include <vector>

#include "clients/lockstep/lockstep.h"
#include "contact/shape/baked/mesh_shape.h"
#include "device-io/device.h"
#include "proto/wire/guide.h"
#include "proto/wire/scene_pose.h"

/// A hand that pushes a box along x, through the session's own steps and, beside it, by an
/// integration of the same equations in steps of 20 µs that shares nothing with them.
namespace haptic::test {

/// A mass on a damper, led by a spring to where the hand means to go; without a spring it flies.
struct HandModel {
  double mass = 0.65, damping = 5.3, stiffness = 300;  // of the simulated hand of the sessions
  std::function<double(double)> intent = [](double) { return 0.0; };   // [m] at a time [s]
  std::function<bool(double)> presses = [](double) { return false; };  // button 0, at a time [s]
  double x = 0, v = 0;                                                 // at the start

  void step(double t, double force, double h) {
    v += h * (force - damping * v + stiffness * (intent(t) - x)) / mass;
    x += h * v;
  }
};

/// Rises by `way` [m] within `duration` [s], with speed and acceleration zero at both ends.
inline std::function<double(double)> rise(double from, double way, double duration) {
  return [=](double t) {
    const double s = std::clamp(t / duration, 0.0, 1.0);
    return from + way * s * s * s * (10 - 15 * s + 6 * s * s);
  };
}

/// The hand as a device along x; the force that it is told is held for a tick.
class PushingHand : public Device {
 public:
  explicit PushingHand(HandModel model) : model_(std::move(model)) {}

  DeviceCaps caps() const override { return {1e6, 0, false, true}; }
  std::string description() const override { return "pushing"; }
  bool read(const TickTime& tick, DeviceState& state) override {
    constexpr double kStep = 20e-6;  // [s]
    constexpr int64_t kStepNs = 20'000;
    if (last_ns_ == 0) last_ns_ = tick.deadline_ns;
    for (; last_ns_ < tick.deadline_ns; last_ns_ += kStepNs, t_ += kStep) {
      model_.step(t_, held_, kStep);
    }
    state = {};
    state.t_ns = tick.deadline_ns;
    state.X_BH.p.x = model_.x;
    state.V_BH.v.x = model_.v;
    state.buttons = model_.presses(t_) ? 1 : 0;
    // passivity control would damp, and there is nothing to guard
    state.flags = kDeviceFresh | kDeviceHomed | kDeviceSimulated | kDeviceOpenLoop;
    return true;
  }
  void write(const Wrench& F_B) override { held_ = F_B.f.x; }
  void stop() override { held_ = 0; }
  const HandModel& hand() const { return model_; }
  void move_at(double speed) { model_.v = speed; }

 private:
  HandModel model_;
  double held_ = 0, t_ = 0;
  int64_t last_ns_ = 0;  // until when it has moved; 0: it has not begun
};

inline constexpr double kBoxEdge = 0.02;  // [m]
inline constexpr double kGravity = 9.81;  // [m/s²]

/// A session of that box, its middle at x = 30 mm, and of a point that pushes it.
struct PushedSession {
  SessionConfig config;
  std::deque<MeshShapeData> owned;
  std::vector<MeshShape> shapes;

  PushedSession(double mass, double stiffness) {
    config.renderer = static_cast<Renderer>(0);
    config.servo_rate = config.sim_rate = 1000;
    config.coupling.translational_stiffness = stiffness;
    config.safety.soft_start = 0;
    config.safety.max_force = 1e5;
    config.safety.slew = 1e9;
    config.safety.velocity_limit = 100;
    add_box({kBoxEdge, kBoxEdge, kBoxEdge}, {0.03, 0, 0}, mass);
  }
  /// A box whose side towards the pushed one touches it, behind and on two sides.
  void add_corner() {
    add_box({kBoxEdge, 0.1, 0.1}, {0.03 + kBoxEdge, 0, 0}, 0);
    add_box({0.1, kBoxEdge, 0.1}, {0.03, kBoxEdge, 0}, 0);
    add_box({0.1, 0.1, kBoxEdge}, {0.03, 0, kBoxEdge}, 0);
  }
  void add_box(const Vec3& extent, const Vec3& p_W, double mass) {
    const primitive::Box box{extent};
    owned.push_back(build_shape(make_box(box)));
    shapes.push_back(owned.back().view());
    ObjectConfig& object = config.objects[config.n_objects++];
    object.primitive = box;
    object.X_WO.p = p_W;
    object.body.mass = mass;
  }
};

inline constexpr double kFace = 0.03 - kBoxEdge / 2;  // of the box, towards the hand [m]

/// A session with its hand, in lockstep.
struct Pushed {
  PushedSession session;
  PushingHand hand;
  Lockstep lockstep;

  Pushed(PushedSession made, HandModel model, uint32_t scene_latency = 0,
         bool without_counters = false)
      : session(std::move(made)),
        hand(std::move(model)),
        lockstep(session.config, session.shapes, hand, options(scene_latency, without_counters)) {}

 private:
  static LockstepOptions options(uint32_t scene_latency, bool without_counters) {
    LockstepOptions all;
    all.scene_latency = scene_latency;
    all.without_counters = without_counters;
    return all;
  }
};

/// The motion integrated from its definition: a hand, a one-sided spring, and a box that is free or
/// fixed. A box that the hand holds by its button is also pulled with k s (hand − place).
struct Integrated {
  std::vector<double> force;  // at each tick [N]
  double hand = 0, box = 0;   // at the end [m]
};
inline Integrated integrate(HandModel hand, double stiffness, double mass, bool is_fixed,
                            int n_ticks) {
  constexpr double kStep = 20e-6;
  Integrated out;
  double box = kFace, v = 0, place = 0, since = -1;
  for (int k = 0; k < 50 * n_ticks; ++k) {
    const double t = k * kStep;
    if (!hand.presses(t)) since = -1;
    if (hand.presses(t) && since < 0) since = t, place = hand.x - box;
    const double depth = hand.x - box - (since < 0 ? 0 : place);
    const double strength = since < 0 ? 0 : std::min((t - since) / kGraspTime, 1.0);
    const double push = stiffness * (hand.x > box ? std::max(depth, 0.0) : strength * depth);
    if (k % 50 == 0) out.force.push_back(push);
    hand.step(t, -push, kStep);
    if (!is_fixed) v += kStep * push / mass;
    box += kStep * v;
  }
  out.hand = hand.x, out.box = box;
  return out;
}

/// Checks the balance of momentum: the impulse that a hand has given [N·s] is the body's momentum
/// and the impulse that servo and sim have forgotten; returns the latter.
inline double check_balance(Lockstep& lockstep, double mass, double given, double forgotten = 0) {
  for (int k = 0; k < 5; ++k) lockstep.step();  // nothing touches any more
  const SceneFrame& scene = lockstep.scene();
  forgotten += lockstep.frame().forgotten_impulse_W.x;
  forgotten += seen_of(scene, 0, kFirstHand)->forgotten_W.x;
  const double has = mass * scene.objects[0].V_WO.v.x;
  CAPTURE(given, forgotten, has);
  const double most = std::max({std::fabs(given), std::fabs(forgotten), std::fabs(has)});
  REQUIRE(most > 1e-3);
  CHECK(std::fabs(given - forgotten - has) <= 1e-9 * most);
  return forgotten;
}

/// Root of the mean square of the difference from tick to tick.
inline double rms_error(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  const size_t n = std::min(a.size(), b.size());
  for (size_t k = 0; k < n; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(sum / static_cast<double>(n));
}

/// Force of each tick of a session [N].
inline std::vector<double> felt(Lockstep& lockstep, int n_ticks) {
  std::vector<double> force;
  for (int k = 0; k < n_ticks && lockstep.step(); ++k) {
    force.push_back(-lockstep.frame().F_coupling_W.f.x);
  }
  return force;
}

/// Largest change of force from one tick to the next, in the last `n` ticks [N].
inline double largest_step(const std::vector<double>& force, size_t n) {
  double most = 0;
  for (size_t k = force.size() - n; k + 1 < force.size(); ++k) {
    most = std::max(most, std::fabs(force[k + 1] - force[k]));
  }
  return most;
}

}  // namespace haptic::test
