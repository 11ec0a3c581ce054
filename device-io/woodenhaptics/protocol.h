// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "device-io/motors/arm.h"

/// The text protocol of a WoodenHaptics with a Teensy (firmware woody_teensy_mini, see
/// docs/references.md), for any number of motors up to six (docs/six-motors.md). The host asks, the
/// device answers:
///   host    [mA,mA,mA]\n                           currents, as many as there are motors
///   device  [model,e0,e1,e2,e3,e4,e5,error]\n      encoder counts
/// A device with buttons adds 256 to its model for the first, 512 for the second, and so on, while
/// they are pressed.
/// A line followed by another before it is read is dropped by the firmware and answered with an
/// error, so a line is sent only when the one before is answered. An answer with an error repeats
/// the counts of the last valid line. After 100 ms without a valid line the motors are switched
/// off.
namespace haptic {

inline constexpr int32_t kFirmwareMaxMilliamperes = 6000;    // larger values count as zero
inline constexpr int64_t kFirmwareWatchdogNs = 100'000'000;  // without a valid line

/// Before its calibration button is pressed, a firmware may report e0 = 8000 + 4000 sin(0.0002 n),
/// e1 = the first current it was sent, and keep the motors off.
inline constexpr int32_t kSineMiddle = 8000, kSineAmplitude = 4000;

/// An invalid line, named by the error the firmware answers it with; it has no other effect. The
/// line that follows is read as usual.
enum class Challenge : int32_t {
  kNone = 0,
  kNoBegin = 256,    // "]": an end without a beginning
  kNotAsMany = 512,  // "[]": not as many numbers as motors
};

/// One line to send; two with a challenge.
struct CommandText {
  std::array<char, 80> text;  // six times sign, ten digits and a comma, and the challenge
  size_t size;
  std::string_view view() const { return {text.data(), size}; }
};

/// The currents of the first `motors` motors.
CommandText encode_currents(const Milliamperes& currents, Challenge before = Challenge::kNone,
                            size_t motors = 3);

/// The line for zero force of three motors, "[0,0,0,0,0,0]\n" of six: sent by stop(), and by
/// hapticd if the servo cannot.
inline constexpr std::string_view kZeroCommand = "[0,0,0]\n";

/// An answer of the device.
struct EncoderReply {
  int32_t model = 0;
  MotorCounts counts{};
  int32_t error = 0;  // not zero: the counts are old
};

inline constexpr int32_t kFirstButton = 8;  // bit of an answer's first number

/// The two halves of an answer's first number.
constexpr int32_t model_of(const EncoderReply& reply) {
  return reply.model & 0xff;
}
/// One bit a button.
constexpr uint32_t buttons_of(const EncoderReply& reply) {
  return static_cast<uint32_t>(reply.model) >> kFirstButton;
}

/// Finds answers in a byte stream, however it is split. Anything else (noise, torn or overlong
/// lines, words, fractions, numbers beyond 32 bits) is skipped: an answer is the text from the last
/// '[' to the next ']', eight integers separated by commas.
class ReplyReader {
 public:
  /// True if this byte completes an answer.
  bool push(char byte, EncoderReply& reply) noexcept;

  /// Number of bracketed texts that were no answer.
  uint64_t rejected() const noexcept { return rejected_; }

 private:
  static constexpr size_t kLongest = 95;  // eight times sign, ten digits and a comma

  std::array<char, kLongest> text_{};
  size_t size_ = 0;
  bool inside_ = false;
  uint64_t rejected_ = 0;
};

}  // namespace haptic
