// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string_view>

#include "device-io/emulator/fault_order.h"
#include "device-io/hand/plant.h"
#include "device-io/woodenhaptics/kinematics.h"
#include "device-io/woodenhaptics/protocol.h"

namespace haptic {

/// What made the emulator write a record.
enum class EmulatorEvent : uint32_t {
  kCommand = 0,     // a good line: the motors do as it says from now on
  kRejected = 1,    // a line that was dropped: the motors go on as before
  kWatchdog = 2,    // no good line for 100 ms: the motors are off from now on
  kSample = 3,      // nothing happened for a while; where the hand is
  kCalibrated = 4,  // the button was pressed
};

/// What the device received and what the hand felt, from this instant on.
struct EmulatorRecord {
  int64_t t_ns;            // of the firmware's clock
  uint64_t commands;       // good lines so far
  uint64_t rejected;       // dropped lines so far
  uint64_t watchdog;       // times the watchdog put the motors off
  Vec3 force_B;            // at the tip, on the hand [N]
  Vec3 p_B;                // where the tip is [m]
  MotorCounts counts;      // the encoders
  MotorCounts answered;    // the counts of the answer before: what the server knew
  MotorCounts said_first;  // those of an old answer that came in front of it; else the same
  Milliamperes currents;   // of the motors, after the firmware's own checks
  uint32_t motors_on;      // 0: the watchdog has put them off, or they never were on
  EmulatorEvent event;
  uint32_t reserved;
};
static_assert(sizeof(EmulatorRecord) % 8 == 0);

struct EmulatedDeviceOptions {
  SimulatedHandConfig hand;  // of the device and of the hand that holds it
  WoodenHapticsGeometry geometry;
  int64_t button_ns = 0;                  // when the calibration button is pressed; 0: not needed
  int64_t sample_period_ns = 10'000'000;  // between records where nothing happens
};

/// A WoodenHaptics on virtual time: bytes in, bytes out. The firmware is that of devices.md 1.2.4
/// with its faults (protocol.h); the arm is a mass with damper and friction at the tip, held by a
/// hand (HandPlant), seen through encoders in the joints and moved by the currents of the motors.
/// Written from the description of the firmware, not from the driver: the two share the kinematics
/// alone.
class EmulatedDevice {
 public:
  EmulatedDevice(const EmulatedDeviceOptions& options, int64_t t_ns);

  /// Bytes that have come over the wire; what the queue cannot hold is lost, as on the wire.
  void receive(std::span<const char> bytes);

  /// One turn of the firmware's loop: time passes to t_ns, then at most one line is read. True
  /// where there is a record; answer() holds what it says, if anything.
  bool turn(int64_t t_ns);

  /// For faults: from the next good line on, that many answers are off by these counts, as with an
  /// encoder that slips. What the record calls answered is what was said.
  void disturb(const MotorCounts& off_by, uint64_t answers);

  /// For faults: from the next line on it answers as this one of EmulatorFault says, until it is
  /// told to be healthy.
  void lie(EmulatorFault how) { lie_ = how; }

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
  MotorCounts encoders();

  EmulatedDeviceOptions options_;
  HandPlant plant_;
  EmulatorRecord record_{};
  int64_t t_ns_;
  int64_t started_ns_;
  int64_t last_command_ns_ = 0;
  int64_t last_record_ns_;
  Vec3 joint_angles_;
  std::array<int32_t, 6> counts_{};      // of the last good line
  std::array<int32_t, 6> said_first_{};  // of the first answer to it
  MotorCounts off_by_{};
  uint64_t disturbed_answers_ = 0;  // still to come
  EmulatorFault lie_ = EmulatorFault::kHealthy;
  std::array<EncoderReply, kLateAnswers> said_{};  // what was, or would have been, last
  uint64_t n_said_ = 0;
  EncoderReply frozen_{.model = kWoodenHapticsModel};  // the last valid one
  std::minstd_rand noise_;
  bool calibrated_;
  uint64_t questions_ = 0;  // while not calibrated
  std::array<char, 4096> queue_{};
  size_t queued_ = 0;
  std::array<char, 128> line_{};
  std::array<char, 256> answer_{};  // two, where an old one comes first
  size_t answer_size_ = 0;
};

}  // namespace haptic
