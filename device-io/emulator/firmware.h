// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <span>
#include <string_view>

#include "device-io/emulator/fault_order.h"
#include "device-io/hand/plant.h"
#include "device-io/woodenhaptics/kinematics.h"
#include "device-io/woodenhaptics/protocol.h"

namespace haptic {

/// Cause of a record.
enum class EmulatorEvent : uint32_t {
  kCommand = 0,     // a valid line: the motors obey it from now on
  kRejected = 1,    // a dropped line: the motors continue as before
  kWatchdog = 2,    // no valid line for 100 ms: the motors are off from now on
  kSample = 3,      // no event for a while; the hand's position
  kCalibrated = 4,  // the calibration button was pressed
};

/// The command that the device received and the wrench that the hand felt, from this instant on.
struct EmulatorRecord {
  int64_t t_ns;            // of the firmware's clock
  uint64_t commands;       // valid lines so far
  uint64_t rejected;       // dropped lines so far
  uint64_t watchdog;       // times the watchdog switched the motors off
  Vec3 force_B;            // on the hand, at the tip or the handle's origin [N]
  Vec3 torque_B;           // on the hand [N·m]
  Vec3 p_B;                // of the tip or the handle's origin [m]
  Quat q_B;                // of the handle
  MotorCounts counts;      // the encoders
  MotorCounts answered;    // counts of the previous answer: what the server knew
  MotorCounts said_first;  // counts of an old answer sent before that; else equal
  Milliamperes currents;   // of the motors, after the firmware's checks [mA]
  uint32_t motors_on;      // 0: switched off by the watchdog, or never on
  EmulatorEvent event;
};
static_assert(sizeof(EmulatorRecord) % 8 == 0);

struct EmulatedDeviceOptions {
  SimulatedHandConfig hand;  // the device and the hand that holds it
  Intention intention{};     // of that hand; none: its seeded one
  PlantLoad load{};          // beside hand and motors
  const Arm* arm = &woodenhaptics_arm();
  int64_t button_ns = 0;                  // instant of the calibration button; 0: not needed
  int64_t sample_period_ns = 10'000'000;  // between records without an event
};

/// A WoodenHaptics, or another arm, on virtual time: bytes in, bytes out. The firmware behaves as
/// in protocol.h, faults included; the arm is a mass with damper and friction at the handle, held
/// by a hand (HandPlant), sensed by encoders in the joints and driven by the motors' currents.
/// Written from the description of the firmware, not from the driver; the two share only the
/// kinematics.
class EmulatedDevice {
 public:
  EmulatedDevice(const EmulatedDeviceOptions& options, int64_t t_ns);

  /// Bytes from the line; those that do not fit into the queue are lost.
  void receive(std::span<const char> bytes);

  /// One turn of the firmware's loop: time advances to t_ns, then at most one line is read. True if
  /// there is a record; answer() holds the answer, if any.
  bool turn(int64_t t_ns);

  /// Fault: from the next valid line on, that many answers are off by these counts, as with a
  /// slipping encoder. The record's `answered` shows what was sent.
  void disturb(const MotorCounts& off_by, uint64_t answers);

  /// Fault: answers in this way from the next line on, until kHealthy.
  void lie(EmulatorFault how) { lie_ = how; }

  /// The hand presses these buttons from now on, one bit each.
  void press(uint32_t buttons) { buttons_ = buttons; }
  /// The hand goes to that place of B by itself; none: back to its intention (lead_plant).
  void lead(const std::optional<Vec3>& place_B);

  std::string_view answer() const { return {answer_.data(), answer_size_}; }
  const EmulatorRecord& record() const { return record_; }
  const HandPlant& plant() const { return plant_; }

 private:
  void pass_time(int64_t t_ns);
  bool has_line() const;
  int read_line();
  bool obey(int error);
  void say(int error);
  void put(const EncoderReply& reply);
  void add_noise();
  void note(int64_t t_ns, EmulatorEvent event);
  void solve();
  MotorEfforts amperes() const;

  EmulatedDeviceOptions options_;
  Intention intention_;  // made once: each step asks it
  HandPlant plant_;
  EmulatorRecord record_{};
  int64_t t_ns_;
  int64_t started_ns_;
  int64_t last_command_ns_ = 0;
  int64_t last_record_ns_;
  JointAngles joint_angles_;
  MotorCounts counts_{};      // of the last valid line
  MotorCounts said_first_{};  // of the first answer to it
  MotorCounts off_by_{};
  uint64_t disturbed_answers_ = 0;  // remaining
  EmulatorFault lie_ = EmulatorFault::kHealthy;
  std::array<EncoderReply, kLateAnswers> said_{};  // last answers, sent or withheld
  uint64_t n_said_ = 0;
  EncoderReply frozen_{};  // the last valid one
  uint32_t buttons_ = 0;
  std::minstd_rand noise_;
  bool calibrated_;
  uint64_t questions_ = 0;  // while not calibrated
  std::array<char, 4096> queue_{};
  size_t queued_ = 0;
  std::array<char, 128> line_{};
  std::array<char, 256> answer_{};  // two, if an old one is sent first
  size_t answer_size_ = 0;
};

}  // namespace haptic
