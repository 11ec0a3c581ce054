// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "device-io/emulator/fault_order.h"
#include "device-io/hand/plant.h"

namespace haptic {

struct EmulatedHaplyOptions {
  SimulatedHandConfig hand{};    // the device and the hand that holds it
  PlantLoad load{};              // beside hand and motors
  PantographConfig arm{};        // its lengths, counts, signs and ports
  bool is_m0 = false;            // two ports, half the counts, torques scaled together
  Vec3 home_B{0, 0.0360555, 0};  // where the handle is held when the board is set up [m]
};

/// A Haply board with a pantograph: the commands of its firmware as its source reads them, byte by
/// byte, with its turn of 50 µs and its timeout of 1 s. It has no watchdog. The handle is held by a
/// hand (HandPlant). Its links are found here by iteration, and its force follows by virtual work
/// from differences, not by the driver's formulas. Source: Haply_Arduino_Firmware 1.5 and
/// Haply_M0_Firmware 0.3.
class EmulatedHaply {
 public:
  using Bytes = std::vector<uint8_t>;

  explicit EmulatedHaply(const EmulatedHaplyOptions& options);

  /// From the host.
  void take(std::span<const uint8_t> bytes, int64_t t_ns);
  /// To the host: all that has been said up to now.
  Bytes give(int64_t t_ns);

  void lie(EmulatorFault how) { lie_ = how; }
  /// It forgets its setup and lets go.
  void cut_power();

  const HandPlant& plant() const { return plant_; }
  /// On the hand, by the motors [N].
  const Vec3& force_B() const { return force_B_; }
  /// Torques of the motors on ports 1 and 2 [N·m].
  const std::array<double, 2>& torques() const { return torques_; }
  double largest_torque() const;
  int setups() const { return setups_; }
  int resets() const { return resets_; }
  /// Questions to a device that has motors.
  uint64_t commands() const { return commands_; }

 private:
  struct Cursor;
  struct Port {
    int motor = 0, encoder = 0;  // device that it belongs to; 0: none
    double base = 0;             // added to the counts since the start
    double counts_per_turn = 1;
  };

  void advance_to(int64_t t_ns);
  void move_to(int64_t t_ns);
  bool run_command();
  bool set_up(Cursor& in);
  bool exert(Cursor& in);
  void answer(int device);
  void say(const Bytes& whole);
  double angle(int link, const Vec3& p_B) const;
  double raw_count(size_t port, const Vec3& p_B) const;
  Vec3 motor_force() const;

  EmulatedHaplyOptions options_;
  EmulatorFault lie_ = EmulatorFault::kHealthy;
  std::deque<uint8_t> in_;
  Bytes out_;
  std::deque<Bytes> said_;         // the last answers with their numbers
  std::optional<uint8_t> number_;  // said, and not yet followed by an answer
  std::vector<Port> ports_;
  std::array<double, 2> torques_{}, mirror_{}, frozen_{};
  int setups_ = 0, resets_ = 0;
  uint64_t commands_ = 0;
  int64_t waits_since_ns_ = 0;  // for the rest of a command; 0: it does not wait
  HandPlant plant_;
  Intention intention_;
  Vec3 force_B_;
  int64_t t_ns_ = 0, turn_ns_ = 0;
  std::minstd_rand random_{1};
};

}  // namespace haptic
