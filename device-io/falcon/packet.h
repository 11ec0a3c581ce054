// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace haptic {

/// The Falcon's packets, 16 bytes each way (libnifalcon's description of the firmware): '<', three
/// numbers of 16 bits in four letters each, the least significant nibble first and 'A' for zero, a
/// byte of flags, a byte without meaning, '>'.
inline constexpr size_t kFalconPacket = 16;
using FalconBytes = std::array<uint8_t, kFalconPacket>;

/// What the host says.
struct FalconCommand {
  std::array<int16_t, 3> motors{};  // words of the motors: −10000 · torque [N·m], at most ±4095
  bool homing = false;              // the answer's homed bits are valid
  uint8_t lights = 0;               // bits 1 to 3; colours differ between descriptions
};

inline constexpr int16_t kMostFalconWord = 4095;
inline constexpr double kFalconWordPerTorque = -10000;  // [1/(N·m)]

/// What the device answers.
struct FalconAnswer {
  std::array<int16_t, 3> counts{};  // of the encoders; they wrap
  uint8_t buttons = 0;              // bit 0 plus, 1 forward, 2 centre, 3 minus
  uint8_t homed = 0;                // a bit per leg; valid only while homing is on
};

FalconBytes encode_falcon(const FalconCommand& command) noexcept;

/// Words for these torques of the joints [N·m]. Where one exceeds kMostFalconWord all are scaled by
/// one factor, so that the force keeps its direction; `saturated` says so. Zero if one is not
/// finite.
std::array<int16_t, 3> falcon_words(const std::array<double, 3>& torques, bool& saturated) noexcept;

/// Finds packets in a stream of bytes: '<' and '>' 16 apart, letters between. What does not fit is
/// dropped up to the next '<'.
class FalconReader {
 public:
  /// Takes one byte; true if it has completed a packet.
  bool push(uint8_t byte, FalconAnswer& answer) noexcept;

  void clear() noexcept { size_ = 0; }
  uint64_t rejected() const noexcept { return rejected_; }

 private:
  void begin_again() noexcept;

  FalconBytes bytes_{};
  size_t size_ = 0;
  uint64_t rejected_ = 0;
};

}  // namespace haptic
