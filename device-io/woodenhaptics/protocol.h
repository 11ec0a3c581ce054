// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

/// The text that a WoodenHaptics with a Teensy speaks (devices.md 1.2.4; firmware
/// woody_teensy_mini of the project WoodenHaptics). The host asks, the device answers:
///   host    [mA,mA,mA]\n                           currents of the motors
///   device  [model,e0,e1,e2,e3,e4,e5,error]\n      encoder counts
/// The firmware drops a line that is followed by another one before it has read it, and says so
/// with an error; so a line is sent only when the one before is answered. An answer with an error
/// repeats the counts of the last line that was good. After 100 ms without a good line the motors
/// are off.
namespace haptic {

inline constexpr int32_t kWoodenHapticsModel = 3;          // 1: Polhem, 2: vintage Phantom
inline constexpr int32_t kFirmwareMaxMilliamperes = 6000;  // a larger one is taken for zero
inline constexpr int64_t kFirmwareWatchdogNs = 100'000'000;

/// Before its calibration button is pressed a firmware may say e0 = 8000 + 4000 sin(0.0002 n),
/// e1 = the first current it was sent, and leave the motors off.
inline constexpr int32_t kSineMiddle = 8000, kSineAmplitude = 4000;

using Milliamperes = std::array<int32_t, 3>;

/// A line that is no command, by the error that the firmware answers it with and with nothing else
/// it does. What follows it is read as if it were not there.
enum class Challenge : int32_t {
  kNone = 0,
  kNoBegin = 256,   // "]": an end without a beginning
  kNotThree = 512,  // "[]": not three numbers
};

/// One line, ready to be sent; two with a challenge.
struct CommandText {
  std::array<char, 48> text;
  size_t size;
  std::string_view view() const { return {text.data(), size}; }
};

CommandText encode_currents(const Milliamperes& currents, Challenge before = Challenge::kNone);

/// The line that asks for no force: what stop() sends, and hapticd when the servo cannot.
inline constexpr std::string_view kZeroCommand = "[0,0,0]\n";

/// What the device says.
struct EncoderReply {
  int32_t model = 0;
  std::array<int32_t, 6> counts{};
  int32_t error = 0;  // not zero: the counts are old
};

/// Finds answers in a stream of bytes, wherever it is cut. Whatever is not an answer (noise, torn
/// and overlong lines, words, fractions, numbers beyond 32 bits) is passed over: an answer is the
/// text from the last '[' to the next ']', eight whole numbers with a comma between two.
class ReplyReader {
 public:
  /// True where this byte completes an answer.
  bool push(char byte, EncoderReply& reply) noexcept;

  /// Bracketed texts that were no answer.
  uint64_t rejected() const noexcept { return rejected_; }

 private:
  static constexpr size_t kLongest = 95;  // eight times sign, ten digits and a comma

  std::array<char, kLongest> text_{};
  size_t size_ = 0;
  bool inside_ = false;
  uint64_t rejected_ = 0;
};

}  // namespace haptic
