// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "device-io/arm/arm_path.h"
#include "device-io/device.h"
#include "device-io/hand/led_intent.h"
#include "device-io/hand/plant.h"

namespace haptic {

/// Work of the hand on the arm since the start [J]; negative: the hand got back more.
struct HandWork {
  double moving = 0;
  double turning = 0;
};

/// An admittance device in a simulated hand: a stiff, position-controlled arm with a sensor of
/// force and torque at its handle. It reaches a commanded pose one tick after the command, on a
/// straight line from where it then is, and rests there until the next command; all of it later by
/// config.admittance.arm_delay. So after a late tick it has rested, and it goes no faster than the
/// commands do by the next one following sooner. The hand moves the sensor
/// only through the arm's controller; with the intended position x_h its force on it is
///   f = k_h (x_h − x) + b_h (ẋ_h − ẋ) − m_h ẍ,
/// m_h the mass of the hand (all that is beyond the sensor), and with the rotation vector θ from
/// the handle to the intended orientation its torque is k_R θ + b_R (ω_h − ω) − J_h ω̇. The sensor
/// gives the mean over the last tick; a change of speed between two ticks belongs to the later one.
/// Torque is measured where config.max_torque says that there is any. The properties of a device's
/// own (mass, friction, encoder) in config.hand do not matter: the arm is as stiff as it can be.
class SimulatedArm final : public Device {
 public:
  explicit SimulatedArm(const DeviceConfig& config);
  /// With another intention than that of config.hand.
  SimulatedArm(const DeviceConfig& config, Intention intention);

  DeviceCaps caps() const override;
  std::string description() const override;
  /// The arm starts at the first read, at the intended pose. False if time has advanced by less
  /// than half a tick: the sensor has no new mean yet.
  bool read(const TickTime& tick, DeviceState& state) override;
  /// A wrench has no effect on it.
  void write(const Wrench& /*F_B*/) override {}
  /// A pose that is not finite is not followed.
  void move(const Pose& X_BH) override;
  /// Leads the intent, within the workspace (led_intent.h).
  void lead(const std::optional<Pose>& X_BH) override;
  void stop() override;

  /// The work, summed over the arm's own parts of a tick, not from what the sensor says.
  const HandWork& hand_work() const { return work_; }
  /// The intended pose now.
  const Pose& intent() const { return intent_B_; }

 private:
  void learn_tick(const TickTime& tick);
  void live(int64_t elapsed_ns);
  Wrench push(const Pose& X_to_B, const Pose& intent_to_B, double h);
  Pose next_intent(int64_t dt_ns);

  SimulatedHandConfig hand_;
  Intention intention_;
  double max_force_, max_torque_;
  Ball reach_;
  ArmPath path_;
  int64_t t_ns_ = 0;                       // since the start
  int64_t start_ns_ = 0;                   // instant of the first read
  int64_t deadline_ns_ = 0, late_ns_ = 0;  // of the last one
  int64_t tick_ns_ = 0;                    // the shortest time between two deadlines; 0: unknown
  Pose X_B_, intent_B_;
  Twist V_B_;
  LedIntent led_;
  HandWork work_;
  DeviceState last_{};
  bool started_ = false;
};

}  // namespace haptic
