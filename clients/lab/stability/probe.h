// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <deque>
#include <functional>

#include "clients/lockstep/lockstep.h"
#include "contact/bake/session.h"
#include "device-io/hand/simulated_hand.h"
#include "proto/config/coupling_margin.h"

namespace haptic {

/// The subject on the bench: one axis of a device in a hand, and the coupling that it renders.
/// Units of an axis that turns in brackets.
struct ProbeSetting {
  bool turning = false;
  SimulatedHandConfig hand;    // device and hand; its intent is not used
  double stiffness = 800;      // of the coupling, at the device [N/m or N·m/rad]
  double damping = 0;          // of the coupling, at the device [N·s/m or N·m·s/rad]
  double rate = 1000;          // of the servo [Hz]
  uint32_t delay = 0;          // ticks from a sample to the wrench that answers it, beyond its own
  bool is_controlled = false;  // with the servo's passivity controller
  double max_damping = 0;      // of that controller [N·s/m]
  double max_rotational_damping = 0;  // [N·m·s/rad]
};

/// Device and hand together on that axis: mass or inertia, damping, and the hand's stiffness.
struct ProbedBody {
  double mass, damping, hand_stiffness;
};
ProbedBody probed_body(const ProbeSetting& setting);

/// The scene of the bench: a block whose top is the plane z = 0. A point presses on it along z; to
/// turn, a cube lies flat on it, and the hand turns that about y. A handle at the origin of B is
/// just outside.
class ProbeScene {
 public:
  explicit ProbeScene(bool turning);
  /// The session of a setting. Its limits are so wide that none acts: what a limit cuts off is not
  /// the coupling's doing.
  SessionConfig session(const ProbeSetting& setting) const;
  ContactShapes shapes() const { return baked_.shapes(); }
  bool turning() const { return turning_; }

 private:
  bool turning_;
  BakedSession baked_;
};

/// The force that presses on the block [N].
inline constexpr double kPress = 2;
/// Half the edge of the cube that lies on it [m]; beyond kPress · kHalfCube the cube tips over.
inline constexpr double kHalfCube = 0.02;

/// Largest wrench about which the axis is linear: the pressing force, or the torque that tips the
/// cube.
inline double linear_limit(bool turning) {
  return turning ? kPress * kHalfCube : kPress;
}

/// A device whose wrench comes late.
class Delayed {
 public:
  explicit Delayed(uint32_t ticks) : waiting_(ticks) {}
  Wrench after(const Wrench& F_B) {
    waiting_.push_back(F_B);
    const Wrench out = waiting_.front();
    waiting_.pop_front();
    return out;
  }

 private:
  std::deque<Wrench> waiting_;
};

/// A simulated hand that something else pushes too, whose motors answer late.
class PushedHand final : public Device {
 public:
  PushedHand(const DeviceConfig& config, Intention intention, uint32_t delay)
      : hand_(config, std::move(intention)), delayed_(delay) {}

  DeviceCaps caps() const override { return hand_.caps(); }
  std::string description() const override { return hand_.description(); }
  bool read(const TickTime& tick, DeviceState& state) override { return hand_.read(tick, state); }
  void write(const Wrench& F_B) override { hand_.write(delayed_.after(F_B) + push_B); }
  void stop() override { hand_.stop(); }
  const HandPlant& plant() const { return hand_.plant(); }

  Wrench push_B;  // beside that of the motors, over the coming tick

 private:
  SimulatedHand hand_;
  Delayed delayed_;
};

/// A handle that moves as it is told whatever the force, seen by the encoders and the filter of a
/// simulated hand.
class LedHandle final : public Device {
 public:
  LedHandle(const SimulatedHandConfig& seen, std::function<Pose(int64_t tick)> path, uint32_t delay)
      : seen_(seen), path_(std::move(path)), delayed_(delay) {}

  DeviceCaps caps() const override;
  std::string description() const override { return "a handle that is led"; }
  bool read(const TickTime& tick, DeviceState& state) override;
  void write(const Wrench& F_B) override { held_B_ = delayed_.after(F_B); }
  void stop() override { held_B_ = {}; }
  const Wrench& held() const { return held_B_; }

 private:
  SimulatedHandConfig seen_;
  std::function<Pose(int64_t)> path_;
  Delayed delayed_;
  int64_t tick_ = 0;
  DeviceState last_{};
  Wrench held_B_;
};

}  // namespace haptic
