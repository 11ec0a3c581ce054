// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "device-io/falcon/packet.h"
#include "device-io/threemotors/motor_mailbox.h"

namespace haptic {

/// The chip of FTDI before the device puts two bytes of modem status before the payload of every
/// packet, and sends them alone where there is nothing.
inline constexpr size_t kModemStatus = 2;
inline constexpr size_t kFtdiPacket = 64;

/// The exchange with a running Falcon: one question, one answer, then the next question at once.
/// Bytes in, bytes out, no clock of its own.
///
/// Answers carry no number, so two things show that they are old. The firmware answers each
/// question once: one too many means that old ones were queued somewhere; then samples are withheld
/// until the line has been silent for kQuietNs. And from time to time a question is a *challenge*:
/// it takes homing back, and an honest answer to it, and to no other, has no homed bits. A firmware
/// that repeats itself, or answers from a queue, misses two in succession and is stale until it
/// meets one. Whether a firmware obeys is tried once it is homed; one that does not is not
/// challenged. The zero of its encoders is not touched: programs switch homing on and off with a
/// homed device.
class FalconExchange {
 public:
  explicit FalconExchange(MotorMailbox& mailbox) : mailbox_(mailbox) {}

  /// Whether a question is due: the last one is answered, or given up after kAskAgainNs.
  bool may_ask(int64_t t_ns) const noexcept;
  /// The next question, from the servo's newest command.
  FalconBytes ask(int64_t t_ns) noexcept;
  /// A packet of the chip, at most kFtdiPacket bytes, its status included.
  void hear(std::span<const uint8_t> packet, int64_t t_ns) noexcept;

  uint64_t asked() const noexcept { return asked_; }
  uint64_t answered() const noexcept { return answered_; }
  uint64_t surplus() const noexcept { return surplus_; }
  uint64_t rejected() const noexcept { return reader_.rejected(); }
  int64_t answered_ns() const noexcept { return answered_ns_; }
  /// The firmware obeys challenges.
  bool is_challenged() const noexcept { return manners_ == Manners::kObeys; }

  static constexpr int64_t kAskAgainNs = 5'000'000;  // an answer takes 1 ms; the rest is the bus
  static constexpr int64_t kQuietNs = 5'000'000;     // old answers come within a millisecond
  static constexpr int kFewestApart = 16, kMostApart = 31;  // questions between challenges

 private:
  enum class Manners { kUnknown, kObeys, kIgnores };

  void take(MotorSample answer, int64_t t_ns) noexcept;
  void judge_challenge(bool met) noexcept;
  bool is_challenge_due() noexcept;

  MotorMailbox& mailbox_;
  FalconReader reader_;
  uint64_t asked_ = 0, answered_ = 0, surplus_ = 0;
  int64_t asked_ns_ = 0, first_asked_ns_ = 0, answered_ns_ = 0, heard_ns_ = 0;
  bool waits_ = false;      // a question is unanswered
  bool distrusts_ = false;  // one answer too many
  // challenges
  Manners manners_ = Manners::kUnknown;
  bool challenges_ = false;  // the last question is one
  uint8_t legs_ = 0;         // homed, by the last other answer
  int tried_ = 0;            // before its manners are known
  int doubt_ = 0;            // rises by a miss, falls by one with each challenge that is met
  bool stale_ = false;
  int until_next_ = 0;  // questions
  uint32_t random_ = 1;
  uint8_t number_ = 0;  // of samples
};

}  // namespace haptic
