// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace haptic {

/// The bytes of a Haply board (its library hAPI; firmware 1.0 and 1.5 of the board with an Arduino
/// Due, 0.3 of the M0), without frames or checksums. To the board: a type, the number of a device
/// that the host chooses, a payload:
///   0 reset;  1 set up: what the device has on which ports;
///   2 the torques of its motors [N·m], each 4 bytes of a float, low byte first.
/// The board answers a question of type 2 at once: the device's number, then the angle of each of
/// its encoders [degrees], a float each.
///
/// A question to a device without motors and encoders is two bytes, and its answer one. Such a
/// *number* precedes each question here: an answer that belongs to the question comes directly
/// behind its number.
///
/// The board is told that a turn has 360 counts, so its degrees are whole counts.

/// The device's number here: hAPI's programs take small ones. As the last byte of a float, where a
/// packet is cut off, it makes a torque of 1e-28 N·m.
inline constexpr uint8_t kHaplyDevice = 0x11;
/// Numbers of questions: no device's of a program, and no last byte of a float that is a count; as
/// such they make a torque of at most 0.2 mN·m.
inline constexpr uint8_t kFirstNumber = 0x12, kLastNumber = 0x38;

/// The board's counts of a turn, which make its degrees counts.
inline constexpr float kCountsAsDegrees = 360;

/// Torques are commanded in this unit [N·m]: an int16 reaches 0.33 N·m, more than a motor has.
inline constexpr double kHaplyTorqueUnit = 1e-5;
inline constexpr int32_t kMostHaplyCounts = 32767;  // two turns and more

/// The set-up of a board's encoder.
struct HaplyEncoder {
  float start = 0;  // angle where it is set up [degrees]
  float counts_per_turn = kCountsAsDegrees;
};

using HaplySetup = std::array<uint8_t, 26>;
using HaplyTorques = std::array<uint8_t, 10>;
using HaplyQuestion = std::array<uint8_t, 2 + 10>;

inline constexpr std::array<uint8_t, 2> kHaplyReset{0, 0};

/// No command: the board passes over each of these bytes. Behind half a question they end it, with
/// a float of less than 1e-36; then what follows is understood.
inline constexpr std::array<uint8_t, 10> kHaplyPadding{3, 3, 3, 3, 3, 3, 3, 3, 3, 3};

/// A device with motors and encoders on ports 1 and 2, turning clockwise by the board's word.
HaplySetup encode_haply_setup(uint8_t device, const std::array<HaplyEncoder, 2>& encoders) noexcept;

/// Torques of the motors on ports 1 and 2 [N·m].
HaplyTorques encode_haply_torques(uint8_t device, const std::array<float, 2>& torques) noexcept;

/// Torques of kHaplyDevice in kHaplyTorqueUnit, with a number before them.
HaplyQuestion encode_haply(uint8_t number, int16_t motor_1, int16_t motor_2) noexcept;

struct HaplyAnswer {
  uint8_t number = 0;
  std::array<int16_t, 2> counts{};  // on ports 1 and 2
};

/// Finds answers behind numbers in a stream of bytes. One has a number, kHaplyDevice, and two
/// floats that are whole, at most kMostHaplyCounts; other bytes are passed over.
class HaplyReader {
 public:
  /// Takes one byte; true if it has completed an answer.
  bool push(uint8_t byte, HaplyAnswer& answer) noexcept;

  /// Bytes that were part of no answer.
  uint64_t passed_over() const noexcept { return bytes_ - kSize * answers_; }

 private:
  static constexpr size_t kSize = 10;

  std::array<uint8_t, kSize> last_{};  // oldest first
  uint64_t bytes_ = 0, answers_ = 0;
};

}  // namespace haptic
