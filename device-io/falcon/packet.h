// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "device-io/motors/motor_mailbox.h"

namespace haptic {

/// The Falcon's packets, 16 bytes each way (libnifalcon's description of the firmware): '<', three
/// numbers of 16 bits in four letters each, the least significant nibble first and 'A' for zero, a
/// byte of flags, a byte without meaning, '>'.
inline constexpr size_t kFalconPacket = 16;
using FalconBytes = std::array<uint8_t, kFalconPacket>;

/// Flags of a MotorCommand: homing is on, and the answer's legs are valid; the lights are bits 1 to
/// 3, whose colours differ between descriptions. Its motors are words of −10000 · torque [N·m], at
/// most ±4095.
inline constexpr uint8_t kFalconHoming = 1, kFalconLights = 0x0e;

/// Flags of a MotorSample: bit 0 plus, 1 forward, 2 centre, 3 minus button; a bit for each leg that
/// is homed, from kFalconLegsAt on.
inline constexpr uint8_t kFalconButtons = 0x0f, kFalconLegs = 0x70;
inline constexpr int kFalconLegsAt = 4;

inline constexpr int16_t kMostFalconWord = 4095;
inline constexpr double kFalconWordPerTorque = -10000;  // [1/(N·m)]

FalconBytes encode_falcon(const MotorCommand& command) noexcept;

/// Finds packets in a stream of bytes: '<' and '>' 16 apart, letters between. What does not fit is
/// dropped up to the next '<'.
class FalconReader {
 public:
  /// Takes one byte; true if it has completed a packet, whose counts and flags are then in
  /// `sample`.
  bool push(uint8_t byte, MotorSample& sample) noexcept;

  void clear() noexcept { size_ = 0; }
  uint64_t rejected() const noexcept { return rejected_; }

 private:
  void begin_again() noexcept;

  FalconBytes bytes_{};
  size_t size_ = 0;
  uint64_t rejected_ = 0;
};

}  // namespace haptic
